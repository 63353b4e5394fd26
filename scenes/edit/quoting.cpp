#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "scenes/edit/message_outline.h"

namespace tessera::edit {
namespace {

void append_utf8(std::string& text, uint32_t c) {
  if (c < 0x80) {
    text += static_cast<char>(c);
  } else if (c < 0x800) {
    text += static_cast<char>(0xC0 | (c >> 6));
    text += static_cast<char>(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    text += static_cast<char>(0xE0 | (c >> 12));
    text += static_cast<char>(0x80 | ((c >> 6) & 0x3F));
    text += static_cast<char>(0x80 | (c & 0x3F));
  } else {
    text += static_cast<char>(0xF0 | ((c >> 18) & 0x07));
    text += static_cast<char>(0x80 | ((c >> 12) & 0x3F));
    text += static_cast<char>(0x80 | ((c >> 6) & 0x3F));
    text += static_cast<char>(0x80 | (c & 0x3F));
  }
}

int digit_of(char c, int base) {
  int value = 99;
  if ('0' <= c && c <= '9') value = c - '0';
  if ('a' <= c && c <= 'f') value = c - 'a' + 10;
  if ('A' <= c && c <= 'F') value = c - 'A' + 10;
  return value < base ? value : -1;
}

/// At most `most` digits from `at` on, which is moved behind them.
uint32_t digits(std::string_view text, size_t& at, int base, int most) {
  uint32_t value = 0;
  for (int i = 0; i < most && at < text.size() && digit_of(text[at], base) >= 0; ++i)
    value = value * static_cast<uint32_t>(base) + static_cast<uint32_t>(digit_of(text[at++], base));
  return value;
}

/// The escape whose letter is at `at`.
void unescape(std::string_view text, size_t& at, std::string& into) {
  const char c = text[at++];
  constexpr std::string_view kLetters = "abfnrtv", kMeant = "\a\b\f\n\r\t\v";
  if (const size_t known = kLetters.find(c); known != std::string_view::npos) {
    into += kMeant[known];
  } else if (c == 'x' || c == 'X') {
    into += static_cast<char>(digits(text, at, 16, 2));
  } else if ('0' <= c && c <= '7') {
    into += static_cast<char>(digits(text, --at, 8, 3));
  } else if (c == 'u' || c == 'U') {
    uint32_t code = digits(text, at, 16, c == 'u' ? 4 : 8);
    if (code >= 0xD800 && code < 0xDC00 && text.substr(at, 2) == "\\u") {
      at += 2;
      code = 0x10000 + ((code - 0xD800) << 10) + (digits(text, at, 16, 4) - 0xDC00);
    }
    append_utf8(into, code);
  } else {
    into += c;
  }
}

}  // namespace

std::string unquote(std::string_view literal) {
  std::string text;
  char mark = '\0';
  for (size_t at = 0; at < literal.size();) {
    const char c = literal[at++];
    if (mark == '\0') {
      if (c == '"' || c == '\'') mark = c;
      if (c == '#') at = std::min(literal.find('\n', at), literal.size());
    } else if (c == mark) {
      mark = '\0';
    } else if (c == '\\' && at < literal.size()) {
      unescape(literal, at, text);
    } else {
      text += c;
    }
  }
  return text;
}

std::string quote(std::string_view text, char mark, bool is_json) {
  std::string made(1, mark);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == mark || c == '\\') {
      made += '\\';
      made += c;
    } else if (c == '\n') {
      made += "\\n";
    } else if (c == '\r') {
      made += "\\r";
    } else if (c == '\t') {
      made += "\\t";
    } else if (byte < 0x20 || byte == 0x7F) {
      made += is_json ? fmt::format("\\u{:04x}", byte) : fmt::format("\\{:03o}", byte);
    } else {
      made += c;
    }
  }
  return made + mark;
}

}  // namespace tessera::edit
