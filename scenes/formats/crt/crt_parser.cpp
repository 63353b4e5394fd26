#include "scenes/formats/crt/crt_parser.h"

#include <fmt/format.h>

namespace tessera {
namespace {

using T = CrtToken;
using K = CrtKind;

constexpr size_t kNoLevel = 99;
/// Operands of modifiers start here: a comparison would eat the '>' that closes them.
constexpr size_t kSum = 3;

/// How tightly a binary operator binds; loosest first.
size_t level_of(T token) {
  switch (token) {
    case T::or_sign:
      return 0;
    case T::and_sign:
      return 1;
    case T::less:
    case T::greater:
    case T::less_equal:
    case T::greater_equal:
    case T::equal:
    case T::not_equal:
      return 2;
    case T::plus:
    case T::minus:
    case T::caret:
      return kSum;
    case T::times:
    case T::divide:
    case T::modulo:
      return 4;
    default:
      return kNoLevel;
  }
}

bool is_modifier(T token) {
  return token == T::keyword_scale || token == T::keyword_translate || token == T::keyword_rotate;
}

bool is_group(std::string_view name) {
  return name == "Union" || name == "Intersection" || name == "Difference";
}

}  // namespace

/// Counts nesting while it lives.
class CrtParser::Deeper {
 public:
  explicit Deeper(CrtParser& parser) : parser_(parser) {
    if (++parser_.depth_ <= kMaxDepth) return;
    --parser_.depth_;
    throw CrtLimitError(parser_.peek().span, "nested too deep",
                        fmt::format("at most {} levels", kMaxDepth));
  }
  ~Deeper() { --parser_.depth_; }
  Deeper(const Deeper&) = delete;
  Deeper& operator=(const Deeper&) = delete;

 private:
  CrtParser& parser_;
};

CrtParser::CrtParser(std::string_view text, CrtSyntaxPool& pool, CrtDiagnostics& diagnostics)
    : text_(text), pool_(pool), diagnostics_(diagnostics), lexer_(text, diagnostics) {}

const CrtSyntax& CrtParser::parse() {
  CrtSyntax& script = make(K::block, peek());
  try {
    statements(script, true);
  } catch (const CrtLimitError& error) {
    diagnostics_.error(error);
  }
  return script;
}

// ------------------------------------------------------------------------------------- statements

void CrtParser::statements(CrtSyntax& into, bool top_level) {
  const int braces = braces_;
  while (peek().token != T::end && !diagnostics_.is_full()) {
    if (peek().token == T::right_brace) {
      if (!top_level) return;
      const CrtSpan where = take().span;
      diagnostics_.error(where, "'}' without a '{' before it", "a statement");
      braces_ = 0;
      continue;
    }
    const uint32_t start = peek().span.offset;
    try {
      into.children.push_back(&statement(top_level));
    } catch (const CrtLimitError&) {
      throw;
    } catch (const CrtError& error) {
      diagnostics_.error(error);
      if (peek().span.offset == start) take();
      skip_to_statement(braces);
      if (braces_ < braces) return;
    }
  }
}

const CrtSyntax& CrtParser::statement(bool top_level) {
  if (top_level && peek().token == T::keyword_settings) {
    CrtSyntax& settings = make(K::settings, take());
    attributes(settings);
    return settings;
  }
  if (top_level && peek().token == T::keyword_scene) return block(K::scene);
  if (word_is("while", "While")) return loop();
  if (word_is("if", "If")) return branch();
  return expression();
}

const CrtSyntax& CrtParser::loop() {
  const Deeper deeper(*this);
  CrtSyntax& node = make(K::loop, take());
  expect(T::left_parenthesis, "while");
  node.children.push_back(&expression());
  expect(T::right_parenthesis, "the condition");
  node.children.push_back(&block(K::block));
  return node;
}

const CrtSyntax& CrtParser::branch() {
  const Deeper deeper(*this);
  CrtSyntax& node = make(K::branch, take());
  expect(T::left_parenthesis, "if");
  node.children.push_back(&expression());
  expect(T::right_parenthesis, "the condition");
  node.children.push_back(&block(K::block));
  const std::string_view word = text_of(peek());
  if (word != "else" && word != "Else") return node;
  const T after = peek(1).token;
  const std::string_view word_after = text_of(peek(1));
  if (after == T::left_brace) {
    take();
    node.children.push_back(&block(K::block));
  } else if (word_after == "if" || word_after == "If") {
    take();
    node.children.push_back(&branch());
  }
  return node;
}

/// Braces around statements; a keyword that opens it (Scene) is still to be taken.
const CrtSyntax& CrtParser::block(CrtKind kind) {
  const Deeper deeper(*this);
  CrtSyntax& node = make(kind, kind == K::scene ? take() : peek());
  const CrtSpan open = expect(T::left_brace, kind == K::scene ? "Scene" : "this").span;
  const int inside = braces_;
  statements(node, false);
  if (braces_ < inside) return node;  // recovery has passed the brace
  if (!accept(T::right_brace) && !diagnostics_.is_full())
    throw CrtError(open, "a '{' that is never closed", "'}' for it");
  return node;
}

void CrtParser::attributes(CrtSyntax& into) {
  const Deeper deeper(*this);
  const CrtSpan open = expect(T::left_brace, text_of({T::name, into.span, false})).span;
  const int inside = braces_;
  while (peek().token != T::right_brace) {
    if (peek().token == T::end) throw CrtError(open, "a '{' that is never closed", "'}' for it");
    if (diagnostics_.is_full()) return;
    try {
      if (peek().token != T::identifier && peek(1).token != T::arrow)
        fail("an attribute (name -> value) or '}'");
      CrtSyntax& attribute = make(K::attribute, take());
      expect(T::arrow, attribute.text);
      attribute.children.push_back(&expression());
      into.children.push_back(&attribute);
    } catch (const CrtLimitError&) {
      throw;
    } catch (const CrtError& error) {
      diagnostics_.error(error);
      skip_to_attribute(inside);
      if (braces_ < inside) return;
    }
  }
  take();
}

// ------------------------------------------------------------------------------------ expressions

const CrtSyntax& CrtParser::expression() {
  const Deeper deeper(*this);
  const CrtSyntax& target = ternary();
  if (peek().token != T::assign) return target;
  if (target.kind != K::identifier)
    throw CrtError(target.span, "a value that cannot be assigned to", "a name before '='");
  CrtSyntax& node = make(K::assignment, take());
  node.span = target.span;
  node.children = {&target, &expression()};
  return node;
}

const CrtSyntax& CrtParser::ternary() {
  const CrtSyntax& condition = binary(0);
  if (peek().token != T::question) return condition;
  const Deeper deeper(*this);
  CrtSyntax& node = make(K::ternary, take());
  node.children.push_back(&condition);
  node.children.push_back(&expression());
  expect(T::colon, "the value for true");
  node.children.push_back(&ternary());
  return node;
}

const CrtSyntax& CrtParser::binary(size_t loosest) {
  const CrtSyntax* left = &unary();
  while (true) {
    const size_t level = level_of(peek().token);
    if (level == kNoLevel || level < loosest) return *left;
    CrtSyntax& node = make(K::binary, take());
    node.children = {left, &binary(level + 1)};
    left = &node;
  }
}

const CrtSyntax& CrtParser::unary() {
  const T token = peek().token;
  if (token != T::plus && token != T::minus && token != T::not_sign) return postfix();
  const Deeper deeper(*this);
  CrtSyntax& node = make(K::unary, take());
  node.children.push_back(&unary());
  return node;
}

const CrtSyntax& CrtParser::postfix() {
  const CrtSyntax* left = &primary();
  while (true) {
    const T token = peek().token;
    if (token == T::left_bracket) {
      CrtSyntax& node = make(K::index, take());
      node.children = {left, &expression()};
      expect(T::right_bracket, "the index");
      left = &node;
    } else if (token == T::left_parenthesis) {
      CrtSyntax& node = make(K::call, take());
      if (left->kind == K::identifier) node.span = left->span;
      node.children.push_back(left);
      arguments(node, T::right_parenthesis);
      left = &node;
    } else if (token == T::less && is_modifier(peek(1).token)) {
      left = &modifiers(*left);
    } else {
      return *left;
    }
  }
}

const CrtSyntax& CrtParser::modifiers(const CrtSyntax& modified) {
  CrtSyntax& node = make(K::modifiers, take());
  node.children.push_back(&modified);
  do {
    if (!is_modifier(peek().token)) fail("scale, translate or rotate");
    CrtSyntax& modifier = make(K::modifier, take());
    modifier.children.push_back(&binary(kSum));
    node.children.push_back(&modifier);
  } while (accept(T::comma));
  if (!accept(T::greater)) fail("',' and another modifier, or '>'");
  return node;
}

const CrtSyntax& CrtParser::primary() {
  const CrtLexeme& next = peek();
  switch (next.token) {
    case T::integer:
      return make(K::integer, take());
    case T::real:
      return make(K::real, take());
    case T::text:
      return make(K::text, take());
    case T::keyword_true:
    case T::keyword_false:
      return make(K::boolean, take());
    case T::identifier:
      return make(K::identifier, take());
    case T::name:
      return object();
    case T::keyword_macro:
      return macro();
    case T::left_parenthesis: {
      take();
      const CrtSyntax& inside = expression();
      expect(T::right_parenthesis, "the expression in parentheses");
      return inside;
    }
    case T::left_bracket: {
      CrtSyntax& list = make(K::list, take());
      arguments(list, T::right_bracket);
      return list;
    }
    case T::arrow:
      fail("a value; attributes (name -> value) stand between the braces of an object");
    default:
      fail("a value");
  }
}

const CrtSyntax& CrtParser::object() {
  CrtSyntax& node = make(K::object, take());
  if (peek().token == T::left_brace && is_group(node.text)) {
    node.kind = K::group;
    const CrtSyntax& inside = block(K::block);
    node.children = inside.children;
    return node;
  }
  attributes(node);
  return node;
}

const CrtSyntax& CrtParser::macro() {
  CrtSyntax& node = make(K::macro, take());
  expect(T::left_parenthesis, "Macro");
  while (peek().token != T::right_parenthesis) {
    if (peek().token != T::identifier) fail("a parameter's name or ')'");
    node.children.push_back(&make(K::identifier, take()));
    if (!accept(T::comma) && peek().token != T::right_parenthesis) fail("',' or ')'");
  }
  take();
  node.children.push_back(&block(K::block));
  return node;
}

void CrtParser::arguments(CrtSyntax& into, CrtToken close) {
  if (accept(close)) return;
  do {
    into.children.push_back(&expression());
  } while (accept(T::comma));
  if (!accept(close)) fail(fmt::format("',' or {}", describe(close)));
}

// ----------------------------------------------------------------------------------------- tokens

const CrtLexeme& CrtParser::peek(size_t ahead) {
  while (ahead_count_ <= ahead) ahead_[ahead_count_++] = lexer_.next();
  return ahead_[ahead];
}

CrtLexeme CrtParser::take() {
  const CrtLexeme taken = peek();
  ahead_[0] = ahead_[1];
  --ahead_count_;
  if (taken.token == T::left_brace) ++braces_;
  if (taken.token == T::right_brace) --braces_;
  return taken;
}

CrtLexeme CrtParser::expect(CrtToken token, std::string_view after) {
  if (peek().token != token) fail(fmt::format("{} after {}", describe(token), after));
  return take();
}

bool CrtParser::accept(CrtToken token) {
  if (peek().token != token) return false;
  take();
  return true;
}

bool CrtParser::word_is(std::string_view small, std::string_view capital) {
  const std::string_view word = text_of(peek());
  return (word == small || word == capital) && peek(1).token == T::left_parenthesis;
}

std::string_view CrtParser::text_of(const CrtLexeme& lexeme) const {
  return text_.substr(lexeme.span.offset, lexeme.span.length);
}

std::string CrtParser::found(const CrtLexeme& lexeme) const {
  constexpr size_t kLongest = 40;
  const std::string_view text = text_of(lexeme);
  if (lexeme.token == T::end) return std::string(describe(T::end));
  if (lexeme.token == T::text) return "a text";
  return text.size() > kLongest ? fmt::format("'{}...'", text.substr(0, kLongest))
                                : fmt::format("'{}'", text);
}

void CrtParser::fail(std::string_view expected) {
  throw CrtError(peek().span, found(peek()), std::string(expected));
}

CrtSyntax& CrtParser::make(CrtKind kind, const CrtLexeme& at) {
  if (pool_.size() >= kMaxNodes)
    throw CrtLimitError(at.span, "the script is too long",
                        fmt::format("at most {} syntax nodes", kMaxNodes));
  return pool_.emplace_back(CrtSyntax{kind, at.token, at.span, text_of(at), {}});
}

void CrtParser::skip_to_statement(int braces) {
  while (peek().token != T::end) {
    const CrtLexeme& next = peek();
    if (braces_ < braces) return;
    if (braces_ == braces) {
      if (next.token == T::right_brace) return;
      if (next.token == T::keyword_settings || next.token == T::keyword_scene) return;
      const bool starts = next.token == T::identifier || next.token == T::name;
      if (next.begins_line && starts && peek(1).token != T::arrow) return;
    }
    take();
  }
}

void CrtParser::skip_to_attribute(int braces) {
  while (peek().token != T::end && braces_ >= braces) {
    const bool here = braces_ == braces;
    if (here && peek().token == T::right_brace) return;
    if (here && peek().token == T::identifier && peek(1).token == T::arrow) return;
    take();
  }
}

}  // namespace tessera
