#include "base/plain_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"

namespace tessera {
namespace {

/// The length of the character at the beginning of `text` if it is to be written out, and its code
/// point; 0 if it is not.
size_t control_at(std::string_view text, unsigned& code) {
  const auto byte = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  code = byte(0);
  if (code < 0x20 || code == 0x7f) return 1;
  if (code == 0xc2 && byte(1) >= 0x80 && byte(1) < 0xa0) return code = byte(1), 2;
  // U+202A to U+202E and U+2066 to U+2069: what follows would be shown in another order.
  if (code != 0xe2) return 0;
  code = 0x2000 + (byte(1) & 0x3f) * 0x40 + (byte(2) & 0x3f);
  const bool turns = (byte(1) == 0x80 && byte(2) >= 0xaa && byte(2) <= 0xae) ||
                     (byte(1) == 0x81 && byte(2) >= 0xa6 && byte(2) <= 0xa9);
  return turns ? 3 : 0;
}

std::string written_out(unsigned code) {
  switch (code) {
    case '\t':
      return "\\t";
    case '\n':
      return "\\n";
    case '\r':
      return "\\r";
    default:
      return code > 0xff ? fmt::format("\\u{:04x}", code) : fmt::format("\\x{:02x}", code);
  }
}

}  // namespace

std::string escape_controls(std::string_view text, bool keeps_lines) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    unsigned code = 0;
    const size_t length = keeps_lines && text[0] == '\n' ? 0 : control_at(text, code);
    if (length == 0)
      out += text[0];
    else
      out += written_out(code);
    text.remove_prefix(std::max<size_t>(length, 1));
  }
  return out;
}

bool is_utf16(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) return true;
  const auto is_text = [](char c) { return (c >= ' ' && c <= '~') || (c >= '\t' && c <= '\r'); };
  return bytes.size() >= 2 &&
         ((bytes[0] == '\0' && is_text(bytes[1])) || (bytes[1] == '\0' && is_text(bytes[0])));
}

void refuse_wide_text(std::string_view bytes, const std::string& name) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xFF\xFE\0\0"sv) || bytes.starts_with("\0\0\xFE\xFF"sv))
    throw scene_error({name, 1, 1}, "text in UTF-32",
                      "UTF-8, as `iconv -f UTF-32 -t UTF-8` makes of it");
  if (is_utf16(bytes))
    throw scene_error({name, 1, 1}, "text in UTF-16",
                      "UTF-8, as `iconv -f UTF-16 -t UTF-8` makes of it");
}

}  // namespace tessera
