#pragma once

#include <spdlog/spdlog.h>

#include <string_view>

namespace tessera {

/// Logging goes to standard error through spdlog's default logger. `level` is one of
/// trace, debug, info, warn, error, off. Lines are "2026-03-01T12:00:00.123+01:00 serve info TEXT".
/// Call before any thread starts; the last call counts.
void configure_logging(std::string_view level, std::string_view process_name);

}  // namespace tessera
