#include <algorithm>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "scenes/edit/outline.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;

bool is_word_start(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '_' || (c & 0x80) != 0;
}
bool is_digit(char c) { return '0' <= c && c <= '9'; }

/// Cuts protobuf's text format into pieces, with a stack of its own: no text nests too deep for it.
class TesseraParser {
 public:
  explicit TesseraParser(std::string_view text) : text_(text) {}

  SyntaxTree parse() {
    const uint32_t end = static_cast<uint32_t>(text_.size());
    at_ = byte_order_mark_size(text_);
    SyntaxNode root{.kind = SyntaxKind::block, .range = {at_, end}, .value = {at_, end}};
    root.body = root.range;
    root.message = v1::Scene::descriptor();
    open_ = {{tree_.add(-1, root), '\0'}};
    for (skip(); at_ < end; skip()) piece();
    while (open_.size() > 1) close(end, false);
    return std::move(tree_);
  }

 private:
  struct Open {
    int32_t node;
    char closing;
  };

  void skip() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        at_ = line_end(text_, at_);
      } else if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v' ||
                 c == '\0') {
        ++at_;
      } else {
        return;
      }
    }
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  void word() {
    while (is_word_start(peek()) || is_digit(peek())) ++at_;
  }

  /// One quoted piece; an open one ends with its line.
  bool quoted() {
    const char quote = text_[at_++];
    while (at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '\r') {
      const char c = text_[at_++];
      if (c == quote) return true;
      if (c == '\\' && at_ < text_.size()) ++at_;
    }
    return false;
  }

  void piece() {
    const char c = peek();
    Open& top = open_.back();
    if (c == '}' || c == '>' || c == ']') return closing(c);
    if (c == ',' || c == ';' || c == ':') {
      ++at_;
      return;
    }
    if (tree_[top.node].kind == SyntaxKind::list) {
      SyntaxNode item{.range = {at_, at_}, .name = {at_, at_}};
      item.field = tree_[top.node].field;
      value(item);
    } else if (is_word_start(c) || c == '[') {
      field();
    } else if (c == '"' || c == '\'') {
      quoted();
    } else {
      ++at_;
    }
  }

  /// A bracket that closes none is passed over; one that closes an outer one closes all within.
  void closing(char c) {
    size_t depth = open_.size();
    while (depth > 1 && open_[depth - 1].closing != c) --depth;
    if (depth <= 1 || (c != '}' && depth != open_.size())) {
      ++at_;
      return;
    }
    while (open_.size() > depth) close(at_, false);
    ++at_;
    close(at_, true);
  }

  void close(uint32_t end, bool is_closed) {
    const int32_t i = open_.back().node;
    open_.pop_back();
    if (i < 0) return;
    SyntaxNode& node = tree_[i];
    node.is_closed = is_closed;
    node.range.end = node.value.end = end;
    node.body.end = is_closed ? end - 1 : end;
  }

  void field() {
    SyntaxNode made{.range = {at_, at_}};
    const pb::Descriptor* message = tree_[std::max(open_.back().node, 0)].message;
    if (peek() == '[') {  // an extension's name
      while (at_ < text_.size() && peek() != ']' && peek() != '\n' && peek() != '{') ++at_;
      if (peek() == ']') ++at_;
      message = nullptr;
    } else {
      word();
    }
    made.name = {made.range.begin, at_};
    made.range.end = at_;
    if (message) made.field = message->FindFieldByName(std::string(text_of(text_, made.name)));
    const uint32_t after_name = at_;
    skip();
    const bool has_colon = peek() == ':';
    if (has_colon) {
      made.range.end = ++at_;
      skip();
    } else if (peek() != '{' && peek() != '<') {
      at_ = after_name;
      made.kind = SyntaxKind::note;
      made.value = made.body = {after_name, after_name};
      tree_.add(open_.back().node, made);
      return;
    }
    value(made);
  }

  void value(SyntaxNode& made) {
    const char c = peek();
    if (c == '{' || c == '<' || c == '[') return bracket(made, c);
    const uint32_t begin = at_, before = made.range.end;
    made.kind = SyntaxKind::scalar;
    if (!scalar(made)) {
      at_ = begin;
      if (made.name.is_empty()) {
        ++at_;  // no item of a list
        return;
      }
      made.value = made.body = {before, before};
      tree_.add(open_.back().node, made);
      return;
    }
    made.value = {begin, at_};
    if (made.body.end == 0) made.body = made.value;
    made.range.end = at_;
    tree_.add(open_.back().node, made);
  }

  void bracket(SyntaxNode& made, char c) {
    made.kind = c == '[' ? SyntaxKind::list : SyntaxKind::block;
    if (made.kind == SyntaxKind::block && made.field) made.message = made.field->message_type();
    made.value = {at_, at_};
    made.body = {++at_, at_};
    made.body.begin = made.body.end = at_;
    const bool is_deep = open_.size() > kMaxOutlineDepth;
    const int32_t node = is_deep ? open_.back().node : tree_.add(open_.back().node, made);
    const char closing = c == '{' ? '}' : c == '<' ? '>' : ']';
    open_.push_back({is_deep ? -1 : node, closing});
    if (is_deep) pass_over();
  }

  /// To the bracket that closes what nests too deep to be told apart.
  void pass_over() {
    int depth = 1;
    for (skip(); at_ < text_.size(); skip()) {
      const char c = peek();
      if (c == '"' || c == '\'') {
        quoted();
        continue;
      }
      ++at_;
      if (c == '{' || c == '<' || c == '[') ++depth;
      if ((c == '}' || c == '>' || c == ']') && --depth == 0) break;
    }
    open_.pop_back();
  }

  /// False where there is no value, and another field begins or the message ends.
  bool scalar(SyntaxNode& made) {
    const char c = peek();
    if (c == '"' || c == '\'') return texts(made);
    if (c == '-') {
      ++at_;
      skip();
    }
    const uint32_t begin = at_;
    if (is_word_start(peek())) {
      word();
      const uint32_t end = at_;
      skip();
      const char next = peek();
      at_ = end;
      return c == '-' || (next != ':' && next != '{' && next != '<');
    }
    while (is_digit(peek()) || is_word_start(peek()) || peek() == '.' ||
           ((peek() == '-' || peek() == '+') && at_ > begin &&
            (text_[at_ - 1] == 'e' || text_[at_ - 1] == 'E')))
      ++at_;
    return at_ > begin;
  }

  /// Adjacent texts are one value.
  bool texts(SyntaxNode& made) {
    int count = 0;
    uint32_t end = at_;
    const uint32_t begin = at_;
    while (peek() == '"' || peek() == '\'') {
      made.is_closed = quoted();
      end = at_;
      if (++count == 1) made.body = {begin + 1, made.is_closed ? end - 1 : end};
      if (!made.is_closed) break;
      skip();
    }
    at_ = end;
    if (count > 1) made.body = {begin, end};
    return true;
  }

  std::string_view text_;
  SyntaxTree tree_;
  std::vector<Open> open_;
  uint32_t at_ = 0;
};

}  // namespace

SyntaxTree parse_tessera(std::string_view text) { return TesseraParser(text).parse(); }

}  // namespace tessera::edit
