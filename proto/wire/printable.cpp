#include "proto/wire/printable.h"

#include "base/plain_text.h"

namespace tessera {

std::string printable(std::string_view text, size_t max_bytes) {
  size_t size = text.size();
  if (size > max_bytes) {
    size = max_bytes;
    while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xc0) == 0x80) --size;
  }
  return escape_controls(text.substr(0, size));
}

}  // namespace tessera
