#include <algorithm>
#include <vector>

#include "scenes/edit/outline.h"
#include "scenes/edit/xml_syntax.h"

namespace tessera::edit {
namespace {

bool is_upper(char c) { return 'A' <= c && c <= 'Z'; }
bool is_number_start(char c) { return ('0' <= c && c <= '9') || c == '-' || c == '+' || c == '.'; }

/// Cuts X3D in the classic encoding and VRML97 into the same pieces as XML: nodes are elements,
/// fields with plain values attributes, DEF and USE among them. A stack of its own.
class ClassicSyntaxParser {
 public:
  explicit ClassicSyntaxParser(std::string_view text) : text_(text) {}

  SyntaxTree parse() {
    const auto end = static_cast<uint32_t>(text_.size());
    at_ = std::min(byte_order_mark_size(text_), end);
    SyntaxNode root{.kind = SyntaxKind::block, .range = {at_, end}};
    root.value = root.body = root.range;
    open_ = {tree_.add(-1, root)};
    for (Word word = next(); word.kind != '\0'; word = next()) piece(word);
    while (open_.size() > 1) close({end, end}, false);
    return std::move(tree_);
  }

 private:
  struct Word {
    char kind = '\0';  ///< 'a' a name, '0' a number, '"' a text, a bracket, '\0' the end
    SourceRange range;
  };

  Word next() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        at_ = line_end(text_, at_);
      } else if (is_space(c) || c == ',') {
        ++at_;
      } else {
        break;
      }
    }
    const uint32_t begin = at_;
    if (at_ >= text_.size()) return {'\0', {begin, begin}};
    const char c = text_[at_++];
    if (c == '{' || c == '}' || c == '[' || c == ']') return {c, {begin, at_}};
    if (c == '"') {
      while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
      at_ = std::min(at_ + 1, static_cast<uint32_t>(text_.size()));
      return {'"', {begin, at_}};
    }
    while (at_ < text_.size() && !is_space(text_[at_]) &&
           std::string_view("{}[],\"#").find(text_[at_]) == std::string_view::npos)
      ++at_;
    return {is_number_start(c) ? '0' : 'a', {begin, at_}};
  }
  Word peek() {
    const uint32_t at = at_;
    const Word word = next();
    at_ = at;
    return word;
  }
  std::string_view text(const Word& word) const { return text_of(text_, word.range); }

  void piece(const Word& word) {
    if (word.kind == '}') {
      if (open_.size() > 1) close(word.range, true);
    } else if (word.kind == 'a') {
      name(word);
    }
  }

  void name(const Word& word) {
    const std::string_view said = text(word);
    if (said == "ROUTE" || said == "PROFILE" || said == "META" || said == "COMPONENT" ||
        said == "UNIT" || said == "IMPORT" || said == "EXPORT") {
      at_ = line_end(text_, at_);
    } else if (said == "PROTO" || said == "EXTERNPROTO") {
      prototype(word);
    } else if (said == "DEF" || said == "USE" || (is_upper(said.front()) && peek().kind == '{')) {
      node(word, word.range.begin, XmlPart::element);
    } else {
      field(word);
    }
  }

  /// PROTO name [ interface ] { nodes }.
  void prototype(const Word& word) {
    next();
    if (peek().kind == '[') pass_list();
    const Word brace = peek();
    if (brace.kind != '{') return;
    SyntaxNode made = element(word.range.begin, word.range, XmlPart::element);
    next();
    made.body = {at_, at_};
    open(made);
  }

  void pass_list() {
    int depth = 0;
    for (Word word = next(); word.kind != '\0'; word = next()) {
      if (word.kind == '[' || word.kind == '{') ++depth;
      if ((word.kind == ']' || word.kind == '}') && --depth <= 0) return;
    }
  }

  SyntaxNode element(uint32_t begin, SourceRange name, XmlPart part) {
    SyntaxNode made{.kind = SyntaxKind::block, .range = {begin, name.end}};
    made.type = static_cast<int16_t>(part);
    made.name = name;
    made.value = made.range;
    made.body = {name.end, name.end};
    return made;
  }

  void open(SyntaxNode& made) {
    made.range.end = made.value.end = at_;
    if (hidden_ > 0 || open_.size() > kMaxOutlineDepth) {
      ++hidden_;
      return;
    }
    open_.push_back(tree_.add(open_.back(), made));
  }

  void close(SourceRange brace, bool is_closed) {
    if (hidden_ > 0 && is_closed) {
      --hidden_;
      return;
    }
    SyntaxNode& node = tree_[open_.back()];
    open_.pop_back();
    node.is_closed = is_closed;
    node.body.end = std::max(brace.begin, node.body.begin);
    node.range.end = node.value.end = std::max(brace.end, node.body.end);
  }

  /// `word` is DEF, USE or the type; `begin` where the name of the field stands that holds the
  /// node.
  void node(const Word& word, uint32_t begin, XmlPart part) {
    Word type = word;
    SyntaxNode known;
    const bool is_use = text(word) == "USE";
    if (is_use || text(word) == "DEF") {
      const Word name = peek();
      if (name.kind != 'a') return;
      next();
      known = attribute(word.range, name.range);
      if (!is_use) {
        type = peek();
        if (type.kind != 'a') return;
        next();
      }
    }
    SyntaxNode made = element(begin, is_use ? word.range : type.range, part);
    const bool has_body = !is_use && peek().kind == '{';
    if (has_body) next();
    made.body = {at_, at_};
    made.range.end = made.value.end = at_;
    if (!has_body) {
      if (hidden_ > 0) return;
      const int32_t leaf = tree_.add(open_.back(), made);
      if (!known.name.is_empty()) tree_.add(leaf, known);
      return;
    }
    open(made);
    if (!known.name.is_empty() && hidden_ == 0) tree_.add(open_.back(), known);
  }

  SyntaxNode attribute(SourceRange name, SourceRange value) {
    SyntaxNode made{.kind = SyntaxKind::scalar,
                    .range = {name.begin, std::max(name.end, value.end)}};
    made.type = static_cast<int16_t>(XmlPart::attribute);
    made.name = name;
    made.value = made.body = value;
    return made;
  }

  void field(const Word& word) {
    const Word first = peek();
    if (open_.size() == 1 && hidden_ == 0) return;
    if (first.kind == '[') return list(word);
    if (first.kind == 'a') {
      const std::string_view said = text(first);
      const bool is_word = said == "TRUE" || said == "FALSE" || said == "NULL" || said == "IS";
      next();
      if (!is_word && is_upper(said.front())) return node(first, word.range.begin, XmlPart::held);
      SourceRange value = first.range;
      if (said == "IS" && peek().kind == 'a') value.end = next().range.end;
      return add(attribute(word.range, value));
    }
    if (first.kind != '0' && first.kind != '"') {
      return add(attribute(word.range, {word.range.end, word.range.end}));
    }
    SourceRange value = first.range;
    while (peek().kind == first.kind) value.end = next().range.end;
    add(attribute(word.range, value));
  }

  void add(const SyntaxNode& made) {
    if (hidden_ == 0) tree_.add(open_.back(), made);
  }

  /// A list of values; one of nodes is passed into.
  void list(const Word& word) {
    const Word bracket = next();
    const Word first = peek();
    if (first.kind == 'a' && text(first) != "TRUE" && text(first) != "FALSE") return;
    while (peek().kind == '0' || peek().kind == '"' || peek().kind == 'a') next();
    const uint32_t end = at_;
    SyntaxNode made = attribute(word.range, {bracket.range.begin, end});
    made.body = {bracket.range.end, end};
    made.is_closed = peek().kind == ']';
    if (made.is_closed) made.range.end = made.value.end = next().range.end;
    add(made);
  }

  std::string_view text_;
  SyntaxTree tree_;
  std::vector<int32_t> open_;
  int hidden_ = 0;
  uint32_t at_ = 0;
};

}  // namespace

SyntaxTree parse_classic_syntax(std::string_view text) { return ClassicSyntaxParser(text).parse(); }

}  // namespace tessera::edit
