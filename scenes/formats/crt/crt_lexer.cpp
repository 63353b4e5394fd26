#include "scenes/formats/crt/crt_lexer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace tessera {
namespace {

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_small(char c) { return c >= 'a' && c <= 'z'; }
constexpr bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
constexpr bool is_word(char c) { return is_digit(c) || is_small(c) || is_capital(c); }

using Spelling = std::pair<std::string_view, CrtToken>;

constexpr std::array<Spelling, 8> kKeywords{{
    {"Settings", CrtToken::keyword_settings},
    {"Scene", CrtToken::keyword_scene},
    {"Macro", CrtToken::keyword_macro},
    {"scale", CrtToken::keyword_scale},
    {"translate", CrtToken::keyword_translate},
    {"rotate", CrtToken::keyword_rotate},
    {"true", CrtToken::keyword_true},
    {"false", CrtToken::keyword_false},
}};

/// Longer ones first.
constexpr std::array<Spelling, 25> kSymbols{{
    {"->", CrtToken::arrow},
    {"<=", CrtToken::less_equal},
    {">=", CrtToken::greater_equal},
    {"==", CrtToken::equal},
    {"!=", CrtToken::not_equal},
    {"&&", CrtToken::and_sign},
    {"||", CrtToken::or_sign},
    {"=", CrtToken::assign},
    {"+", CrtToken::plus},
    {"-", CrtToken::minus},
    {"*", CrtToken::times},
    {"/", CrtToken::divide},
    {"%", CrtToken::modulo},
    {"^", CrtToken::caret},
    {"!", CrtToken::not_sign},
    {"<", CrtToken::less},
    {">", CrtToken::greater},
    {"?", CrtToken::question},
    {":", CrtToken::colon},
    {"(", CrtToken::left_parenthesis},
    {")", CrtToken::right_parenthesis},
    {"[", CrtToken::left_bracket},
    {"]", CrtToken::right_bracket},
    {"{", CrtToken::left_brace},
    {"}", CrtToken::right_brace},
}};

size_t utf8_length(char first) {
  const auto byte = static_cast<unsigned char>(first);
  return byte < 0x80 ? 1 : byte < 0xe0 ? 2 : byte < 0xf0 ? 3 : 4;
}

void append_utf8(std::string& out, uint32_t code) {
  if (code >= 0xd800 && code < 0xe000) code = 0xfffd;  // half of a pair is no character
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += static_cast<char>(0xc0 | code >> 6);
    out += static_cast<char>(0x80 | (code & 0x3f));
  } else {
    out += static_cast<char>(0xe0 | code >> 12);
    out += static_cast<char>(0x80 | (code >> 6 & 0x3f));
    out += static_cast<char>(0x80 | (code & 0x3f));
  }
}

/// Reads up to `most` digits of `base` at `at`, which it moves behind them.
uint32_t read_digits(std::string_view text, size_t& at, size_t most, uint32_t base) {
  uint32_t value = 0;
  for (size_t i = 0; i < most && at < text.size(); ++i) {
    const char c = text[at];
    uint32_t digit = 99;
    if (is_digit(c)) digit = static_cast<uint32_t>(c - '0');
    if (c >= 'a' && c <= 'f') digit = static_cast<uint32_t>(c - 'a') + 10;
    if (c >= 'A' && c <= 'F') digit = static_cast<uint32_t>(c - 'A') + 10;
    if (digit >= base) break;
    value = value * base + digit;
    ++at;
  }
  return value;
}

}  // namespace

std::string_view describe(CrtToken token) {
  static constexpr std::array<std::string_view, 40> kTexts{"the end of the script",
                                                           "a name",
                                                           "an object",
                                                           "an integer",
                                                           "a number",
                                                           "a text",
                                                           "'Settings'",
                                                           "'Scene'",
                                                           "'Macro'",
                                                           "'scale'",
                                                           "'translate'",
                                                           "'rotate'",
                                                           "'true'",
                                                           "'false'",
                                                           "'='",
                                                           "'->'",
                                                           "'+'",
                                                           "'-'",
                                                           "'*'",
                                                           "'/'",
                                                           "'%'",
                                                           "'^'",
                                                           "'!'",
                                                           "'<'",
                                                           "'>'",
                                                           "'<='",
                                                           "'>='",
                                                           "'=='",
                                                           "'!='",
                                                           "'&&'",
                                                           "'||'",
                                                           "'?'",
                                                           "':'",
                                                           "'('",
                                                           "')'",
                                                           "'['",
                                                           "']'",
                                                           "'{'",
                                                           "'}'",
                                                           "','"};
  return kTexts[static_cast<size_t>(token)];
}

CrtLexeme CrtLexer::made(CrtToken token, size_t start) const {
  return {token, {static_cast<uint32_t>(start), static_cast<uint32_t>(at_ - start)}, false};
}

bool CrtLexer::skip_blanks() {
  bool begins_line = at_ == 0;
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (c == '\n' || c == '\r') begins_line = true;
    if (text_.substr(at_, 2) == "--")
      at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
    else if (c == ' ' || c == '\t' || c == '\n' || c == '\r')
      ++at_;
    else
      break;
  }
  return begins_line;
}

CrtLexeme CrtLexer::next() {
  bool begins_line = false;
  while (true) {
    begins_line = skip_blanks() || begins_line;
    if (at_ >= text_.size()) {
      at_ = text_.size();
      CrtLexeme end = made(CrtToken::end, at_);
      end.begins_line = true;
      return end;
    }
    const char c = text_[at_];
    const bool begins_number =
        is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]));
    CrtLexeme lexeme;
    if (is_small(c) || is_capital(c))
      lexeme = word();
    else if (begins_number)
      lexeme = number();
    else if (c == '"')
      lexeme = quoted();
    else
      lexeme = symbol();
    if (lexeme.token == CrtToken::end) continue;  // it was reported
    lexeme.begins_line = begins_line;
    return lexeme;
  }
}

CrtLexeme CrtLexer::word() {
  const size_t start = at_;
  while (at_ < text_.size() && is_word(text_[at_])) ++at_;
  const std::string_view text = text_.substr(start, at_ - start);
  for (const auto& [spelling, token] : kKeywords)
    if (spelling == text) return made(token, start);
  return made(is_small(text.front()) ? CrtToken::identifier : CrtToken::name, start);
}

CrtLexeme CrtLexer::number() {
  const size_t start = at_;
  bool real = false;
  while (at_ < text_.size() && (is_digit(text_[at_]) || (text_[at_] == '.' && !real)))
    real |= text_[at_++] == '.';
  return made(real ? CrtToken::real : CrtToken::integer, start);
}

CrtLexeme CrtLexer::quoted() {
  const size_t start = at_++;
  while (at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '\r') {
    const char c = text_[at_++];
    if (c == '"') return made(CrtToken::text, start);
    if (c == '\\' && at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '\r') ++at_;
  }
  diagnostics_.error(made(CrtToken::end, start).span, "a text that is not closed",
                     "'\"' on the same line");
  return made(CrtToken::text, start);
}

CrtLexeme CrtLexer::symbol() {
  const size_t start = at_;
  const std::string_view rest = text_.substr(at_);
  for (const auto& [spelling, token] : kSymbols) {
    if (!rest.starts_with(spelling)) continue;
    at_ += spelling.size();
    return made(token, start);
  }
  if (rest.front() == ',') {
    ++at_;
    return made(CrtToken::comma, start);
  }
  if (static_cast<unsigned char>(rest.front()) < 0x20) {
    ++at_;
    diagnostics_.error(made(CrtToken::end, start).span, "binary data", "the text of a CRT script");
    at_ = text_.size();
    return {};
  }
  at_ += std::min(utf8_length(rest.front()), rest.size());
  const std::string_view bad = text_.substr(start, at_ - start);
  diagnostics_.error(made(CrtToken::end, start).span, fmt::format("the character '{}'", bad),
                     bad == "&"   ? "'&&'"
                     : bad == "|" ? "'||'"
                     : bad == "#" ? "'--' before a comment"
                     : bad == "_" ? "names of letters and digits only"
                     : bad == ";" ? "no sign at the end of a statement"
                                  : "a character of the language");
  return {};
}

std::string unescape_crt(std::string_view quoted) {
  std::string_view text = quoted;
  if (text.starts_with('"')) text.remove_prefix(1);
  if (text.ends_with('"')) text.remove_suffix(1);
  std::string out;
  for (size_t i = 0; i < text.size();) {
    if (text[i] != '\\' || i + 1 == text.size()) {
      out += text[i++];
      continue;
    }
    const char c = text[++i];
    constexpr std::string_view kFrom = "btnfr", kTo = "\b\t\n\f\r";
    if (c == 'u') {
      append_utf8(out, read_digits(text, ++i, 4, 16));
    } else if (c >= '0' && c <= '7') {
      append_utf8(out, read_digits(text, i, c <= '3' ? 3 : 2, 8));
    } else {
      const size_t known = kFrom.find(c);
      out += known == std::string_view::npos ? c : kTo[known];
      ++i;
    }
  }
  return out;
}

}  // namespace tessera
