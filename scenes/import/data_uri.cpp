#include "scenes/import/data_uri.h"

#include <array>
#include <cstdint>

namespace tessera {
namespace {

std::optional<std::string> decode_base64(std::string_view text) {
  std::array<int, 256> codes;
  codes.fill(-1);
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < kAlphabet.size(); ++i)
    codes[static_cast<unsigned char>(kAlphabet[i])] = static_cast<int>(i);
  while (text.ends_with('=')) text.remove_suffix(1);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const int code = codes[static_cast<unsigned char>(c)];
    if (code < 0) return std::nullopt;
    bits = bits << 6 | static_cast<uint32_t>(code);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 0xFF);
  }
  return bytes;
}

}  // namespace

std::optional<DataUri> read_data_uri(std::string_view uri) {
  if (!uri.starts_with("data:")) return std::nullopt;
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64"))
    return DataUri{.problem = "a data: URI that is not base64", .expected = "data:...;base64,..."};
  auto bytes = decode_base64(uri.substr(comma + 1));
  if (!bytes)
    return DataUri{.problem = "a data: URI that holds other characters", .expected = "base64"};
  return DataUri{.bytes = *std::move(bytes)};
}

}  // namespace tessera
