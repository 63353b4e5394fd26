#include "scenes/edit/crt_syntax.h"

#include <algorithm>
#include <vector>

#include "scenes/edit/outline.h"
#include "scenes/formats/crt/crt_lexer.h"

namespace tessera::edit {
namespace {

using T = CrtToken;
using P = CrtPart;

bool is_modifier(T token) {
  return token == T::keyword_scale || token == T::keyword_translate || token == T::keyword_rotate;
}

/// Operands of modifiers take no comparisons: one would eat the '>' that closes them.
bool is_operator(T token, bool is_modifying) {
  switch (token) {
    case T::plus:
    case T::minus:
    case T::caret:
    case T::times:
    case T::divide:
    case T::modulo:
      return true;
    case T::or_sign:
    case T::and_sign:
    case T::less:
    case T::greater:
    case T::less_equal:
    case T::greater_equal:
    case T::equal:
    case T::not_equal:
      return !is_modifying;
    default:
      return false;
  }
}

/// Takes a script apart by the grammar of docs/crt.md, passing over what does not fit.
class CrtSyntaxParser {
 public:
  explicit CrtSyntaxParser(std::string_view text) : text_(text) {
    const uint32_t mark = byte_order_mark_size(text);
    CrtDiagnostics diagnostics("", text.substr(mark));
    CrtLexer lexer(text.substr(mark), diagnostics);
    do {
      tokens_.push_back(lexer.next());
      tokens_.back().span.offset += mark;
    } while (tokens_.back().token != T::end);
  }

  SyntaxTree parse() {
    const int script = make(P::script);
    while (peek() != T::end) statements(script, true);
    SyntaxNode& root = parts_[0].node;
    root.range = {byte_order_mark_size(text_), static_cast<uint32_t>(text_.size())};
    root.value = root.body = root.range;
    SyntaxTree tree;
    flatten(tree, 0, -1);
    return tree;
  }

 private:
  struct Part {
    SyntaxNode node;
    std::vector<int> children;
  };
  /// Counts nesting while it lives.
  struct Deeper {
    explicit Deeper(int& depth) : depth_(depth) { ++depth_; }
    ~Deeper() { --depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    int& depth_;
  };

  T peek(size_t ahead = 0) const {
    return tokens_[std::min(at_ + ahead, tokens_.size() - 1)].token;
  }
  SourceRange range_of(size_t token) const {
    const CrtSpan span = tokens_[std::min(token, tokens_.size() - 1)].span;
    return {span.offset, span.offset + span.length};
  }
  std::string_view word() const { return text_of(text_, range_of(at_)); }
  uint32_t last_end() const { return at_ == 0 ? range_of(0).begin : range_of(at_ - 1).end; }
  bool accept(T token) {
    if (peek() != token) return false;
    ++at_;
    return true;
  }

  int make(P type) {
    SyntaxNode node{.type = static_cast<int16_t>(type)};
    const uint32_t begin = range_of(at_).begin;
    node.range = node.name = node.value = node.body = {begin, begin};
    parts_.push_back({node, {}});
    return static_cast<int>(parts_.size()) - 1;
  }
  SyntaxNode& node(int part) { return parts_[static_cast<size_t>(part)].node; }
  void hold(int part, int child) {
    if (child >= 0) parts_[static_cast<size_t>(part)].children.push_back(child);
  }
  int finish(int part, SyntaxKind kind) {
    SyntaxNode& made = node(part);
    made.kind = kind;
    made.range.end = std::max(last_end(), made.range.begin);
    if (made.value.is_empty()) made.value = {made.range.begin, made.range.end};
    if (made.body.is_empty() && kind == SyntaxKind::scalar) made.body = made.value;
    return part;
  }
  int leaf(P type) {
    const int made = make(type);
    ++at_;
    return finish(made, SyntaxKind::scalar);
  }

  void flatten(SyntaxTree& tree, int part, int32_t parent) {
    const int32_t made = tree.add(parent, node(part));
    for (const int child : parts_[static_cast<size_t>(part)].children) flatten(tree, child, made);
  }

  bool is_deep() const { return depth_ > kMaxOutlineDepth; }

  /// Over brackets that nest too deep.
  int pass_over() {
    const T first = peek();
    if (first == T::end || first == T::right_brace || first == T::right_bracket ||
        first == T::right_parenthesis)
      return -1;
    const int made = make(P::computed);
    int open = 0;
    do {
      const T token = peek();
      if (token == T::left_brace || token == T::left_bracket || token == T::left_parenthesis)
        ++open;
      if (token == T::right_brace || token == T::right_bracket || token == T::right_parenthesis)
        --open;
      if (token == T::end || open < 0) break;
      ++at_;
    } while (open > 0);
    return finish(made, SyntaxKind::scalar);
  }

  void open_body(int part) {
    node(part).value.begin = range_of(at_).begin;
    ++at_;
    node(part).body.begin = last_end();
  }
  void close_body(int part, T closing) {
    const uint32_t end = range_of(at_).begin;
    const bool is_closed = peek() == closing;
    if (is_closed) ++at_;
    SyntaxNode& made = node(part);
    made.is_closed = is_closed;
    made.body.end = is_closed ? end : std::max(last_end(), made.body.begin);
    made.value.end = std::max(last_end(), made.value.begin);
  }

  void statements(int into, bool is_top) {
    while (peek() != T::end) {
      if (peek() == T::right_brace) {
        if (!is_top) return;
        ++at_;
        continue;
      }
      const size_t before = at_;
      hold(into, statement(is_top));
      if (at_ == before) ++at_;
    }
  }

  bool is_word(std::string_view small, std::string_view capital) const {
    return (word() == small || word() == capital) && peek(1) == T::left_parenthesis;
  }

  int statement(bool is_top) {
    const Deeper deeper(depth_);
    if (is_deep()) return pass_over();
    if (is_top && peek() == T::keyword_settings) return with_attributes(P::settings);
    if (is_top && peek() == T::keyword_scene) return with_statements(P::scene);
    if (is_word("while", "While")) return conditional(P::loop);
    if (is_word("if", "If")) return conditional(P::branch);
    if ((word() == "else" || word() == "Else") && peek(1) == T::left_brace)
      return with_statements(P::block);
    if ((word() == "else" || word() == "Else") && peek(1) == T::identifier) ++at_;
    if (is_word("if", "If")) return conditional(P::branch);
    return expression();
  }

  int with_statements(P type) {
    const int made = make(type);
    if (peek() != T::left_brace) {
      ++at_;
      node(made).name = range_of(at_ - 1);
    }
    braces(made);
    return finish(made, SyntaxKind::block);
  }

  void braces(int made) {
    if (peek() != T::left_brace) return;
    open_body(made);
    statements(made, false);
    close_body(made, T::right_brace);
  }

  int conditional(P type) {
    const int made = make(type);
    ++at_;
    node(made).name = range_of(at_ - 1);
    if (accept(T::left_parenthesis)) {
      hold(made, expression());
      accept(T::right_parenthesis);
    }
    braces(made);
    return finish(made, SyntaxKind::block);
  }

  int with_attributes(P type) {
    const int made = make(type);
    ++at_;
    node(made).name = range_of(at_ - 1);
    if (peek() != T::left_brace) return finish(made, SyntaxKind::block);
    open_body(made);
    while (peek() != T::end && peek() != T::right_brace) {
      if (peek(1) != T::arrow) {
        ++at_;
        continue;
      }
      const int attribute = make(P::attribute);
      at_ += 2;
      node(attribute).name = range_of(at_ - 2);
      const bool has_value = !(peek(1) == T::arrow);
      node(attribute).value = {range_of(at_).begin, range_of(at_).begin};
      if (!has_value || peek() == T::right_brace || peek() == T::end)
        node(attribute).value = {last_end(), last_end()};
      const uint32_t begin = node(attribute).value.begin;
      if (has_value) hold(attribute, expression());
      finish(attribute, SyntaxKind::scalar);
      node(attribute).value = {std::min(begin, last_end()), last_end()};
      node(attribute).body = node(attribute).value;
      hold(made, attribute);
    }
    close_body(made, T::right_brace);
    return finish(made, SyntaxKind::block);
  }

  int expression() {
    const Deeper deeper(depth_);
    if (is_deep()) return pass_over();
    const int target = operators(false);
    if (target < 0 || peek() != T::assign) return target;
    const int made = make(P::assignment);
    ++at_;
    node(made).range.begin = node(target).range.begin;
    node(made).name = node(target).range;
    node(made).value = {last_end(), last_end()};
    hold(made, target);
    const int value = expression();
    hold(made, value);
    if (value >= 0) node(made).value = node(value).range;
    node(made).body = node(made).value;
    return finish(made, SyntaxKind::scalar);
  }

  /// All operators at once: only what is computed from what is told apart. Chains are flat.
  int operators(bool is_modifying) {
    const int first = unary();
    if (first < 0 ||
        (!is_operator(peek(), is_modifying) && (is_modifying || peek() != T::question)))
      return first;
    const int made = make(P::computed);
    node(made).range.begin = node(first).range.begin;
    node(made).value = node(made).body = {};
    hold(made, first);
    while (is_operator(peek(), is_modifying) ||
           (!is_modifying && (peek() == T::question || peek() == T::colon))) {
      ++at_;
      const size_t before = at_;
      hold(made, unary());
      if (at_ == before) break;
    }
    return finish(made, SyntaxKind::scalar);
  }

  int unary() {
    const size_t begin = at_;
    while (peek() == T::plus || peek() == T::minus || peek() == T::not_sign) ++at_;
    const size_t signs = at_ - begin;
    const int inner = postfix();
    if (signs == 0 || inner < 0) return inner;
    const P type = crt_part(node(inner));
    const bool is_number = type == P::integer || type == P::real;
    if (signs == 1 && tokens_[begin].token == T::minus && is_number) {
      SyntaxNode& number = node(inner);
      number.range.begin = number.value.begin = number.body.begin = range_of(begin).begin;
      return inner;
    }
    const int made = make(P::computed);
    node(made).range.begin = range_of(begin).begin;
    node(made).value = node(made).body = {};
    hold(made, inner);
    return finish(made, SyntaxKind::scalar);
  }

  /// Behind a value, whatever follows it is of one node, so that chains do not nest.
  int postfix() {
    int left = primary();
    if (left < 0) return left;
    constexpr int kMostWrapped = 50;
    for (int wraps = 0; wraps < kMostWrapped;) {
      const int before = left;
      if (peek() == T::left_bracket) {
        left = wrapped(P::computed, left);
        ++at_;
        hold(left, expression());
        accept(T::right_bracket);
      } else if (peek() == T::left_parenthesis) {
        const bool is_named = crt_part(node(left)) == P::identifier;
        const SourceRange name = node(left).range;
        left = wrapped(is_named ? P::call : P::computed, left);
        if (is_named) {
          node(left).name = name;
          parts_[static_cast<size_t>(left)].children.clear();
        }
        ++at_;
        arguments(left, T::right_parenthesis);
      } else if (peek() == T::less && is_modifier(peek(1))) {
        left = wrapped(P::modifiers, left);
        modifiers(left);
      } else {
        return left;
      }
      finish(left, SyntaxKind::scalar);
      node(left).value = node(left).body = node(left).range;
      if (left != before) ++wraps;
    }
    return left;
  }

  int wrapped(P type, int left) {
    if (crt_part(node(left)) == type && type != P::call) return left;
    const int made = make(type);
    node(made).range.begin = node(left).range.begin;
    node(made).name = {node(made).range.begin, node(made).range.begin};
    node(made).value = node(made).body = {};
    hold(made, left);
    return made;
  }

  void modifiers(int into) {
    ++at_;
    while (is_modifier(peek())) {
      const int made = make(P::modifier);
      ++at_;
      node(made).name = range_of(at_ - 1);
      const int value = operators(true);
      hold(made, value);
      node(made).value = node(made).body =
          value >= 0 ? node(value).range : SourceRange{last_end(), last_end()};
      finish(made, SyntaxKind::scalar);
      hold(into, made);
      if (!accept(T::comma)) break;
    }
    accept(T::greater);
  }

  int primary() {
    const Deeper deeper(depth_);
    if (is_deep()) return pass_over();
    switch (peek()) {
      case T::integer:
        return leaf(P::integer);
      case T::real:
        return leaf(P::real);
      case T::text:
        return leaf(P::text);
      case T::keyword_true:
      case T::keyword_false:
        return leaf(P::boolean);
      case T::identifier:
        return leaf(P::identifier);
      case T::name:
        return object();
      case T::keyword_macro:
        return macro();
      case T::left_parenthesis: {
        const int made = make(P::computed);
        ++at_;
        hold(made, expression());
        accept(T::right_parenthesis);
        return finish(made, SyntaxKind::scalar);
      }
      case T::left_bracket: {
        const int made = make(P::list);
        open_body(made);
        arguments_inside(made, T::right_bracket);
        close_body(made, T::right_bracket);
        return finish(made, SyntaxKind::list);
      }
      default:
        return -1;
    }
  }

  int object() {
    const std::string_view name = word();
    const bool is_group = name == "Union" || name == "Intersection" || name == "Difference";
    return is_group && peek(1) == T::left_brace ? with_statements(P::group)
                                                : with_attributes(P::object);
  }

  int macro() {
    const int made = make(P::macro);
    ++at_;
    node(made).name = range_of(at_ - 1);
    if (accept(T::left_parenthesis)) {
      while (peek() == T::identifier) {
        hold(made, leaf(P::parameter));
        accept(T::comma);
      }
      accept(T::right_parenthesis);
    }
    braces(made);
    return finish(made, SyntaxKind::block);
  }

  void arguments_inside(int into, T close) {
    while (peek() != close && peek() != T::end) {
      const size_t before = at_;
      hold(into, expression());
      if (!accept(T::comma) && at_ == before) return;
      if (peek() == T::right_brace) return;
    }
  }
  void arguments(int into, T close) {
    arguments_inside(into, close);
    accept(close);
  }

  std::string_view text_;
  std::vector<CrtLexeme> tokens_;
  std::vector<Part> parts_;
  size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

SyntaxTree parse_crt_syntax(std::string_view text) { return CrtSyntaxParser(text).parse(); }

}  // namespace tessera::edit
