#include "proto/wire/printable.h"

#include <algorithm>

namespace tessera {
namespace {

/// U+202A to U+202E and U+2066 to U+2069: what follows would be shown in another order.
bool is_bidi_control(std::string_view text) {
  if (text.size() < 3 || !text.starts_with("\xe2")) return false;
  const auto second = static_cast<unsigned char>(text[1]);
  const auto third = static_cast<unsigned char>(text[2]);
  return (second == 0x80 && third >= 0xaa && third <= 0xae) ||
         (second == 0x81 && third >= 0xa6 && third <= 0xa9);
}

}  // namespace

std::string printable(std::string_view text, size_t max_bytes) {
  const auto byte = [&text](size_t i) { return static_cast<unsigned char>(text[i]); };
  size_t size = text.size();
  if (size > max_bytes) {
    size = max_bytes;
    while (size > 0 && (byte(size) & 0xc0) == 0x80) --size;
  }
  std::string result(text.substr(0, size));
  for (size_t i = 0; i < size; ++i) {
    if (byte(i) < 0x20 || byte(i) == 0x7f) result[i] = ' ';
    // U+0080 to U+009F are control characters too.
    if (is_bidi_control(text.substr(i, std::min<size_t>(3, size - i)))) {
      result[i] = result[i + 1] = result[i + 2] = ' ';
    }
    if (byte(i) == 0xc2 && i + 1 < size && byte(i + 1) < 0xa0) result[i] = result[i + 1] = ' ';
  }
  return result;
}

}  // namespace tessera
