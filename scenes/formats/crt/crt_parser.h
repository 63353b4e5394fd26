#pragma once

#include <array>
#include <string_view>

#include "scenes/formats/crt/crt_syntax.h"

namespace tessera {

/// Reads a script by recursive descent. Reports what is wrong to the diagnostics and goes on at the
/// next attribute or statement.
class CrtParser {
 public:
  static constexpr int kMaxDepth = 1500;
  static constexpr size_t kMaxNodes = 4'000'000;

  /// `text` and `pool` must outlive the tree.
  CrtParser(std::string_view text, CrtSyntaxPool& pool, CrtDiagnostics& diagnostics);
  /// A block of statements.
  const CrtSyntax& parse();

 private:
  class Deeper;

  // Statements.
  const CrtSyntax& statement(bool top_level);
  const CrtSyntax& loop();
  const CrtSyntax& branch();
  const CrtSyntax& block(CrtKind kind);
  void statements(CrtSyntax& into, bool top_level);
  void attributes(CrtSyntax& into);

  // Expressions, loosest first.
  const CrtSyntax& expression();
  const CrtSyntax& ternary();
  /// Operators that bind at least as tightly as `loosest`.
  const CrtSyntax& binary(size_t loosest);
  const CrtSyntax& unary();
  const CrtSyntax& postfix();
  const CrtSyntax& modifiers(const CrtSyntax& modified);
  const CrtSyntax& primary();
  const CrtSyntax& object();
  const CrtSyntax& macro();
  /// Expressions with commas between them, up to and with `close`.
  void arguments(CrtSyntax& into, CrtToken close);

  // Tokens.
  const CrtLexeme& peek(size_t ahead = 0);
  CrtLexeme take();
  CrtLexeme expect(CrtToken token, std::string_view after);
  bool accept(CrtToken token);
  bool word_is(std::string_view small, std::string_view capital);
  std::string_view text_of(const CrtLexeme& lexeme) const;
  std::string found(const CrtLexeme& lexeme) const;
  [[noreturn]] void fail(std::string_view expected);
  CrtSyntax& make(CrtKind kind, const CrtLexeme& at);
  void skip_to_statement(int braces);
  void skip_to_attribute(int braces);

  std::string_view text_;
  CrtSyntaxPool& pool_;
  CrtDiagnostics& diagnostics_;
  CrtLexer lexer_;
  std::array<CrtLexeme, 2> ahead_;
  size_t ahead_count_ = 0;
  int braces_ = 0;  ///< open ones
  int depth_ = 0;
};

}  // namespace tessera
