#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tessera {

/// What a data: URI holds, or what is wrong with it.
struct DataUri {
  std::string bytes{};
  std::string problem{};   ///< empty: none
  std::string expected{};  ///< in place of the problem
};

/// The bytes of a data: URI in base64 (RFC 2397); nothing for another URI.
std::optional<DataUri> read_data_uri(std::string_view uri);

}  // namespace tessera
