#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace tessera {

/// "1 worker", "2 workers".
template <typename Count>
std::string counted(Count count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace tessera
