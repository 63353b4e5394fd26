#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace tessera {

/// Starts `arguments[0]`, found by PATH, with its output thrown away. Throws render_error where it
/// cannot be started.
pid_t start_process(const std::vector<std::string>& arguments);

/// Runs it and returns the wall-clock seconds from start to end. Throws render_error unless it ends
/// with exit code 0.
double timed_process(const std::vector<std::string>& arguments);

}  // namespace tessera
