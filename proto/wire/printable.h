#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera {

/// What another process or a file says, for a terminal or a log: without control characters, which
/// escape_controls writes out, and of more than `max_bytes` the rest is cut off before, between
/// characters of UTF-8.
std::string printable(std::string_view text, size_t max_bytes = 1000);

}  // namespace tessera
