#include "scenes/edit/message_writer.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/edit/literal.h"
#include "scenes/edit/message_outline.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;
using Type = pb::FieldDescriptor;

/// The last child behind which a field of that kind belongs, by the order of the schema.
int32_t sibling_before(const SyntaxTree& tree, int32_t parent, const Type& field) {
  int32_t same = -1, earlier = -1;
  for (int32_t i = tree[parent].first_child; i >= 0; i = tree[i].next) {
    const Type* other = tree[i].field;
    if (!other) continue;
    if (other == &field) same = i;
    if (other->index() < field.index()) earlier = i;
  }
  return same >= 0 ? same : earlier;
}

}  // namespace

MessageWriter::MessageWriter(const Outline& outline)
    : text_(outline.text()),
      tree_(outline.tree()),
      is_json_(outline.language() == Language::json || outline.language() == Language::gltf) {
  if (!is_json_) return;
  for (int32_t i = 1; i < tree_.size(); ++i) {
    const SyntaxNode& node = tree_[i];
    if (node.name.is_empty() || node.value.begin < node.name.end + 2) continue;
    const bool is_tight = text_of(text_, {node.name.end + 1, node.value.begin}) == ":";
    if (is_tight) colon_ = ":", comma_ = ",";
    return;
  }
}

std::string MessageWriter::literal(const Type& field, std::string_view typed,
                                   std::string_view old) const {
  const char mark = !is_json_ && old.starts_with('\'') ? '\'' : '"';
  switch (field.cpp_type()) {
    case Type::CPPTYPE_STRING:
      return quote(typed, mark, is_json_);
    case Type::CPPTYPE_ENUM:
      return is_json_ ? quote(trimmed(typed), '"', true) : std::string(trimmed(typed));
    case Type::CPPTYPE_BOOL:
      return std::string(trimmed(typed));
    case Type::CPPTYPE_DOUBLE:
    case Type::CPPTYPE_FLOAT: {
      const std::string_view number = trimmed(typed);
      // The text format may leave out the zero before a point, and takes one before digits for
      // octal.
      const bool is_plain =
          number.find_first_of("+") != 0 && !number.starts_with('0') && !number.starts_with("-0");
      return is_json_ || !is_plain ? strict_number(number) : std::string(number);
    }
    default: {
      const std::string number = strict_number(trimmed(typed));
      return number == "-0" ? "0" : number;
    }
  }
}

std::string MessageWriter::render_value(const Draft& draft) const {
  if (!draft.field->message_type()) return draft.literal;
  std::string inside;
  for (const Draft& part : draft.parts) {
    if (!inside.empty()) inside += is_json_ ? comma_ : " ";
    inside += render(part);
  }
  if (is_json_) return "{" + inside + "}";
  return inside.empty() ? "{ }" : "{ " + inside + " }";
}

std::string MessageWriter::render(const Draft& draft) const {
  const std::string value = render_value(draft);
  if (is_json_) {
    const std::string& name = draft.field->json_name();
    return json_member(name, draft.field->is_repeated() ? json_list({value}) : value);
  }
  return fmt::format("{}{}{}", draft.field->name(), draft.field->message_type() ? " " : ": ",
                     value);
}

uint32_t MessageWriter::behind_separator(uint32_t end) const {
  if (is_json_) return end;
  uint32_t at = end;
  while (at < text_.size() && is_blank(text_[at])) ++at;
  return at < text_.size() && (text_[at] == ',' || text_[at] == ';') ? at + 1 : end;
}

bool MessageWriter::ends_line(uint32_t offset) const {
  uint32_t at = offset;
  while (at < text_.size() && is_blank(text_[at])) ++at;
  return at >= text_.size() || text_[at] == '\n' || text_[at] == '\r' ||
         (!is_json_ && text_[at] == '#');
}

/// Whether commas have to stand between the node and its siblings.
bool MessageWriter::is_separated(int32_t node) const {
  const int32_t parent = tree_[node].parent;
  return is_json_ || (parent >= 0 && tree_[parent].kind == SyntaxKind::list);
}

TextEdit MessageWriter::behind(int32_t sibling, std::string_view made) const {
  const SourceRange there = tree_[sibling].range;
  const bool has_commas = is_separated(sibling);
  const uint32_t end = has_commas ? there.end : behind_separator(there.end);
  const bool has_own_line = begins_line(text_, there.begin) &&
                            ends_line(has_commas && !is_json_ ? end : behind_separator(end));
  const bool next_begins_line =
      has_commas && begins_line(text_, there.begin) &&
      (tree_[sibling].next < 0 || begins_line(text_, tree_[tree_[sibling].next].range.begin));
  if (has_commas) {
    const std::string gap = next_begins_line ? std::string(line_ending(text_, there.begin)) +
                                                   std::string(indentation(text_, there.begin))
                                             : comma_.substr(1);
    return {{end, end}, fmt::format(",{}{}", gap, made)};
  }
  if (!has_own_line) {
    const std::string_view mark = end > there.end ? text_.substr(end - 1, 1) : "";
    return {{end, end}, fmt::format(" {}{}", made, mark)};
  }
  const uint32_t at = line_end(text_, end);
  return {
      {at, at},
      fmt::format("{}{}{}", line_ending(text_, there.end), indentation(text_, there.begin), made)};
}

TextEdit MessageWriter::before(int32_t sibling, std::string_view made) const {
  const uint32_t at = tree_[sibling].range.begin;
  const std::string_view comma = is_separated(sibling) ? "," : "";
  if (begins_line(text_, at))
    return {{at, at},
            fmt::format("{}{}{}{}", made, comma, line_ending(text_, at), indentation(text_, at))};
  const std::string gap = is_separated(sibling) ? comma_.substr(1) : " ";
  return {{at, at}, fmt::format("{}{}{}", made, comma, gap)};
}

TextEdit MessageWriter::insert_into_empty(int32_t parent, const std::string& text) const {
  const SyntaxNode& node = tree_[parent];
  if (parent == 0 && !is_json_) {
    const uint32_t end = node.range.end;
    const std::string ending(line_ending(text_, end));
    const bool is_free = line_begin(text_, end) == end;
    return {{end, end}, (is_free ? "" : ending) + text + ending};
  }
  if (parent == 0 && node.value == node.body) {
    const uint32_t end = node.range.end;
    return {{end, end}, "{" + text + "}" + std::string(line_ending(text_, end))};
  }
  const std::string_view body = text_of(text_, node.body);
  const uint32_t at = node.body.begin;
  if (body.find_first_of("\n\r") != std::string_view::npos) {
    const std::string unit = indentation_unit(text_, "  ");
    return {{at, at},
            fmt::format("{}{}{}{}", line_ending(text_, at), indentation(text_, node.range.begin),
                        unit, text)};
  }
  if (is_json_) return {{at, at}, text};
  const bool has_blank = !body.empty() && is_blank(body.front());
  return {{at, at}, fmt::format(" {}{}", text, has_blank ? "" : " ")};
}

TextEdit MessageWriter::append_to_list(int32_t list, const std::string& item) const {
  if (tree_[list].last_child >= 0) return behind(tree_[list].last_child, item);
  const uint32_t at = tree_[list].body.begin;
  return {{at, at}, item};
}

TextEdit MessageWriter::insert_one(int32_t parent, const Draft& draft) const {
  const int32_t sibling = sibling_before(tree_, parent, *draft.field);
  if (sibling >= 0) {
    const SyntaxNode& there = tree_[sibling];
    if (there.field == draft.field && there.kind == SyntaxKind::list)
      return append_to_list(sibling, render_value(draft));
    return behind(sibling, render(draft));
  }
  if (tree_[parent].first_child >= 0) return before(tree_[parent].first_child, render(draft));
  return insert_into_empty(parent, render(draft));
}

std::vector<TextEdit> MessageWriter::insert(int32_t parent,
                                            const std::vector<Draft>& drafts) const {
  if (tree_[parent].first_child < 0 && drafts.size() > 1) {
    std::string all;
    for (const Draft& draft : drafts) {
      if (!all.empty()) all += is_json_ ? comma_ : " ";
      all += render(draft);
    }
    return {insert_into_empty(parent, all)};
  }
  std::vector<TextEdit> edits;
  for (const Draft& draft : drafts) {
    TextEdit made = insert_one(parent, draft);
    const auto same = std::find_if(edits.begin(), edits.end(), [&](const TextEdit& other) {
      return other.range == made.range;
    });
    if (same == edits.end()) {
      edits.push_back(std::move(made));
    } else {
      same->text += made.text;
    }
  }
  std::stable_sort(edits.begin(), edits.end(), [](const TextEdit& a, const TextEdit& b) {
    return a.range.begin < b.range.begin;
  });
  return edits;
}

TextEdit MessageWriter::insert_behind(int32_t node, std::string_view copy) const {
  return behind(node, copy);
}

TextEdit MessageWriter::append(int32_t parent, std::string_view item) const {
  const int32_t last = tree_[parent].last_child;
  return last >= 0 ? behind(last, item) : insert_into_empty(parent, std::string(item));
}

std::string MessageWriter::json_member(std::string_view name, std::string_view value) const {
  return fmt::format("\"{}\"{}{}", name, colon_, value);
}

std::string MessageWriter::json_list(const std::vector<std::string>& items) const {
  return fmt::format("[{}]", fmt::join(items, comma_));
}

std::string MessageWriter::json_block(
    const std::vector<std::pair<std::string_view, std::string>>& members) const {
  std::vector<std::string> items;
  for (const auto& [name, value] : members) items.push_back(json_member(name, value));
  return fmt::format("{{{}}}", fmt::join(items, comma_));
}

TextEdit MessageWriter::remove_from_list(int32_t i) const {
  const SyntaxNode& node = tree_[i];
  if (node.next >= 0) return {{node.range.begin, tree_[node.next].range.begin}, ""};
  int32_t previous = -1;
  for (int32_t k = tree_[node.parent].first_child; k != i; k = tree_[k].next) previous = k;
  if (previous >= 0) return {{tree_[previous].range.end, node.range.end}, ""};
  return {node.range, ""};
}

TextEdit MessageWriter::remove(int32_t i) const {
  if (is_separated(i)) return remove_from_list(i);
  const SourceRange there = tree_[i].range;
  const uint32_t end = behind_separator(there.end);
  uint32_t after = end;
  while (after < text_.size() && is_blank(text_[after])) ++after;
  const bool ends = after >= text_.size() || text_[after] == '\n' || text_[after] == '\r';
  const bool begins = begins_line(text_, there.begin);
  if (begins && ends) return {{line_begin(text_, there.begin), next_line(text_, end)}, ""};
  if (begins) return {{there.begin, after}, ""};
  uint32_t begin = there.begin;
  while (begin > 0 && is_blank(text_[begin - 1])) --begin;
  // Something has to stay between what was apart.
  const bool has_blank = after > end || ends;
  return {{has_blank ? begin : there.begin, end}, ""};
}

}  // namespace tessera::edit
