#pragma once

#include <string>
#include <vector>

namespace tessera {

/// Runs `arguments[0]`, found by PATH, with its output thrown away; the wall-clock seconds from
/// start to end. Throws render_error unless it ends with exit code 0.
double timed_process(const std::vector<std::string>& arguments);

}  // namespace tessera
