#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "scenes/edit/outline.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;

/// The field that JSON calls `name`: by its JSON name or the one of the schema.
const pb::FieldDescriptor* json_field(const pb::Descriptor& type, std::string_view name) {
  const std::string written(name);
  if (const auto* field = type.FindFieldByName(written)) return field;
  return type.FindFieldByCamelcaseName(written);
}

/// Cuts JSON into pieces, with a stack of its own: no text nests too deep for it.
class JsonParser {
 public:
  JsonParser(std::string_view text, bool is_scene) : text_(text), is_scene_(is_scene) {}

  SyntaxTree parse() {
    const uint32_t end = static_cast<uint32_t>(text_.size());
    at_ = byte_order_mark_size(text_);
    skip();
    SyntaxNode root{.kind = SyntaxKind::block, .range = {byte_order_mark_size(text_), end}};
    if (is_scene_) root.message = v1::Scene::descriptor();
    root.value = root.body = root.range;
    tree_.add(-1, root);
    if (peek() != '{') return std::move(tree_);
    tree_[0].value.begin = at_++;
    tree_[0].body.begin = at_;
    open_ = {{0, '}'}};
    for (skip(); at_ < end && !open_.empty(); skip()) piece();
    while (!open_.empty()) close(end, false);
    tree_[0].range.end = end;
    return std::move(tree_);
  }

 private:
  struct Open {
    int32_t node;
    char closing;
  };

  void skip() {
    while (at_ < text_.size() &&
           (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
      ++at_;
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  bool quoted() {
    ++at_;
    while (at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '\r') {
      const char c = text_[at_++];
      if (c == '"') return true;
      if (c == '\\' && at_ < text_.size()) ++at_;
    }
    return false;
  }

  void piece() {
    const char c = peek();
    if (c == '}' || c == ']') return closing(c);
    if (c == ',' || c == ':') {
      ++at_;
      return;
    }
    if (tree_[open_.back().node].kind == SyntaxKind::list) {
      SyntaxNode item{.range = {at_, at_}, .name = {at_, at_}};
      item.field = tree_[open_.back().node].field;
      value(item);
    } else if (c == '"') {
      member();
    } else {
      ++at_;
    }
  }

  void closing(char c) {
    size_t depth = open_.size();
    while (depth > 0 && open_[depth - 1].closing != c) --depth;
    if (depth == 0) {
      ++at_;
      return;
    }
    while (open_.size() > depth) close(at_, false);
    ++at_;
    close(at_, true);
  }

  void close(uint32_t end, bool is_closed) {
    SyntaxNode& node = tree_[open_.back().node];
    open_.pop_back();
    node.is_closed = is_closed;
    node.range.end = node.value.end = end;
    node.body.end = is_closed ? end - 1 : end;
  }

  void member() {
    SyntaxNode made{.range = {at_, at_}};
    const SyntaxNode& holder = tree_[open_.back().node];
    const bool is_named = quoted();
    made.name = {made.range.begin + 1, is_named ? at_ - 1 : at_};
    made.range.end = at_;
    if (holder.message) {
      const bool is_map = holder.field && holder.field->is_map();
      made.field = is_map ? holder.message->FindFieldByName("value")
                          : json_field(*holder.message, text_of(text_, made.name));
    }
    const uint32_t after_name = at_;
    skip();
    if (peek() != ':') {
      at_ = after_name;
      made.kind = SyntaxKind::note;
      made.value = made.body = {after_name, after_name};
      tree_.add(open_.back().node, made);
      return;
    }
    made.range.end = ++at_;
    skip();
    value(made);
  }

  void value(SyntaxNode& made) {
    const char c = peek();
    if (c == '{' || c == '[') return bracket(made, c);
    const uint32_t begin = at_;
    if (c == '"') {
      made.is_closed = quoted();
      made.body = {begin + 1, made.is_closed ? at_ - 1 : at_};
    } else {
      while (at_ < text_.size() &&
             std::string_view(",:]}[{\"\n\r\t ").find(peek()) == std::string_view::npos)
        ++at_;
      made.body = {begin, at_};
    }
    if (at_ == begin) {
      made.value = made.body = {made.range.end, made.range.end};
      if (made.name.is_empty()) {
        ++at_;
        return;
      }
    } else {
      made.value = {begin, at_};
      made.range.end = at_;
    }
    tree_.add(open_.back().node, made);
  }

  void bracket(SyntaxNode& made, char c) {
    made.kind = c == '[' ? SyntaxKind::list : SyntaxKind::block;
    if (made.kind == SyntaxKind::block && made.field) made.message = made.field->message_type();
    made.value.begin = at_++;
    made.body.begin = at_;
    if (open_.size() > kMaxOutlineDepth) return pass_over();
    const int32_t holder = open_.back().node;
    open_.push_back({tree_.add(holder, made), c == '{' ? '}' : ']'});
  }

  void pass_over() {
    int depth = 1;
    while (at_ < text_.size() && depth > 0) {
      const char c = peek();
      if (c == '"') {
        quoted();
        continue;
      }
      ++at_;
      if (c == '{' || c == '[') ++depth;
      if (c == '}' || c == ']') --depth;
    }
  }

  std::string_view text_;
  bool is_scene_;
  SyntaxTree tree_;
  std::vector<Open> open_;
  uint32_t at_ = 0;
};

}  // namespace

SyntaxTree parse_json(std::string_view text, bool is_scene) {
  return JsonParser(text, is_scene).parse();
}

}  // namespace tessera::edit
