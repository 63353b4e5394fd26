#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// The name among `names` that `text` means, in which '_' may stand for '-'; nothing: none.
inline std::optional<std::string> find_choice(std::span<const std::string> names,
                                              std::string_view text) {
  const auto same = [](char a, char b) { return (a == '_' ? '-' : a) == (b == '_' ? '-' : b); };
  const auto found = std::ranges::find_if(
      names, [&](const std::string& name) { return std::ranges::equal(name, text, same); });
  return found == names.end() ? std::nullopt : std::optional(*found);
}

}  // namespace tessera
