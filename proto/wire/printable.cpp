#include "proto/wire/printable.h"

namespace tessera {

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
    if (byte(i) == 0xc2 && i + 1 < size && byte(i + 1) < 0xa0) result[i] = result[i + 1] = ' ';
  }
  return result;
}

}  // namespace tessera
