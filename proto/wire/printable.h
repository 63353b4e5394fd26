#pragma once

#include <string>
#include <string_view>

namespace tessera {

/// What another process said, for a terminal or a log: control characters become spaces, and of
/// more than 1,000 bytes the rest is cut off, between characters of UTF-8.
std::string printable(std::string_view text);

}  // namespace tessera
