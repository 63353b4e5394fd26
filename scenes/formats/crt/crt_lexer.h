#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "scenes/formats/crt/crt_diagnostics.h"

namespace tessera {

enum class CrtToken : uint8_t {
  end,
  identifier,  ///< begins with a small letter
  name,        ///< begins with a capital letter
  integer,
  real,
  text,  ///< in quotes
  keyword_settings,
  keyword_scene,
  keyword_macro,
  keyword_scale,
  keyword_translate,
  keyword_rotate,
  keyword_true,
  keyword_false,
  assign,
  arrow,
  plus,
  minus,
  times,
  divide,
  modulo,
  caret,
  not_sign,
  less,
  greater,
  less_equal,
  greater_equal,
  equal,
  not_equal,
  and_sign,
  or_sign,
  question,
  colon,
  left_parenthesis,
  right_parenthesis,
  left_bracket,
  right_bracket,
  left_brace,
  right_brace,
  comma,
};

/// How a token of that kind reads in a message: "'{'", "a name".
std::string_view describe(CrtToken token);

struct CrtLexeme {
  CrtToken token = CrtToken::end;
  CrtSpan span;
  bool begins_line = false;  ///< nothing but blanks and comments before it on its line
};

/// Cuts a script into tokens, one at a time. Blanks, line ends and comments ("--" to the end of the
/// line, so that `a--b` is `a`) only separate.
class CrtLexer {
 public:
  /// Both must outlive this.
  CrtLexer(std::string_view text, CrtDiagnostics& diagnostics)
      : text_(text), diagnostics_(diagnostics) {}
  /// Reports what is no token and goes on behind it. After the last token: end, as often as asked.
  CrtLexeme next();

 private:
  bool skip_blanks();
  CrtLexeme word();
  CrtLexeme number();
  CrtLexeme quoted();
  CrtLexeme symbol();
  CrtLexeme made(CrtToken token, size_t start) const;

  std::string_view text_;
  CrtDiagnostics& diagnostics_;
  size_t at_ = 0;
};

/// The characters that a quoted text stands for. Java's escapes: \b \t \n \f \r \" \' \\, \uXXXX
/// and octal ones; of others the backslash falls.
std::string unescape_crt(std::string_view quoted);

}  // namespace tessera
