#include "scenes/edit/word_vocabulary.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/edit/crt_outline.h"
#include "scenes/edit/crt_syntax.h"
#include "scenes/edit/crt_words.h"
#include "scenes/edit/message_vocabulary.h"
#include "scenes/edit/x3d_words.h"
#include "scenes/edit/xml_syntax.h"
#include "scenes/formats/x3d/document/x3d_nodes.h"

namespace tessera::edit {
namespace {

bool is_word_character(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == '_' ||
         c == '-';
}

/// Values of a field: its choices, names of nodes, files.
void add_x3d_values(const Outline& outline, std::string_view type, const Field& field,
                    Completions& into) {
  for (const std::string& choice : field.choices) into.items.push_back({choice, choice, "", ""});
  if (field.kind == ValueKind::file)
    into.files = type == "Inline" ? Completions::Files::model : Completions::Files::picture;
  if (field.kind != ValueKind::reference) return;
  for (const Entity& entity : outline.entities())
    for (const Field& one : entity.fields)
      if (one.name == "DEF") into.items.push_back({one.text, one.text, entity.type, ""});
}

/// Fields that the element does not have yet, also those of nodes if `with_nodes`; `suffix` is
/// written behind each.
void add_x3d_fields(const Outline& outline, const SyntaxNode& element, const X3dNodeType& type,
                    std::string_view suffix, bool with_nodes, Completions& into) {
  const SyntaxTree& tree = outline.tree();
  for (const std::string& name : type.field_names()) {
    const bool holds_nodes = !type.has_field(name);
    if (holds_nodes && !with_nodes) continue;
    bool is_there = false;
    for (int32_t k = element.first_child; k >= 0; k = tree[k].next) {
      const SourceRange named = xml_part(tree[k]) == XmlPart::held
                                    ? word_around(outline.text(), tree[k].range.begin)
                                    : tree[k].name;
      is_there |= text_of(outline.text(), named) == name && named != into.replaced;
    }
    if (!is_there)
      into.items.push_back({name, fmt::format("{}{}", name, suffix),
                            holds_nodes ? "node" : detail_of(describe_x3d(type.name, name, "")),
                            ""});
  }
}

void add_x3d_nodes(std::string_view suffix, Completions& into) {
  for (const std::string& name : x3d_node_names())
    into.items.push_back(
        {name, fmt::format("{}{}", name, suffix), std::string(name_of(x3d_entity_kind(name))), ""});
}

/// What a place of the classic encoding is in, and where that begins.
struct ClassicPlace {
  std::optional<uint32_t> list, string;
  bool is_comment = false;
};

/// Of the end of `range`, which begins outside of all these.
ClassicPlace classic_place(std::string_view text, SourceRange range) {
  ClassicPlace place;
  std::vector<uint32_t> lists;
  for (uint32_t at = range.begin; at < range.end; ++at) {
    if (text[at] == '#') {
      at = line_end(text, at);
      place.is_comment = at >= range.end;
    } else if (text[at] == '"') {
      const uint32_t begin = at;
      while (++at < range.end && text[at] != '"') at += text[at] == '\\' ? 1 : 0;
      if (at >= range.end) place.string = begin;
    } else if (text[at] == '[') {
      lists.push_back(at);
    } else if (text[at] == ']' && !lists.empty()) {
      lists.pop_back();
    }
  }
  if (!lists.empty()) place.list = lists.back();
  return place;
}

/// The word before a place, with nothing but blanks between.
std::string_view word_before(std::string_view text, uint32_t at) {
  while (at > 0 && is_space(text[at - 1])) --at;
  return text_of(text, {word_around(text, at).begin, at});
}

/// The attribute that the place is behind the arrow of; -1: none.
int32_t attribute_at(const SyntaxTree& tree, int32_t object, size_t offset) {
  for (int32_t k = tree[object].first_child; k >= 0; k = tree[k].next) {
    const bool is_next = tree[k].next < 0 || tree[tree[k].next].range.begin > offset;
    if (offset > tree[k].name.end && is_next &&
        offset <= std::max(tree[k].range.end, tree[k].value.end) + 1)
      return k;
  }
  return -1;
}

int32_t object_at(const SyntaxTree& tree, size_t offset) {
  for (int32_t i = tree.node_at(offset); i > 0; i = tree[i].parent) {
    const CrtPart part = crt_part(tree[i]);
    const bool is_block = part == CrtPart::object || part == CrtPart::settings;
    const bool is_inside =
        tree[i].body.begin <= offset && (offset <= tree[i].body.end || !tree[i].is_closed);
    if (is_block && is_inside && !tree[i].body.is_empty()) return i;
    if (tree[i].kind == SyntaxKind::block && is_inside) return -1;
  }
  return -1;
}

void add_values(const Outline& outline, const Field& field, Completions& into) {
  const bool is_quoted = into.replaced.begin > 0 && outline.text()[into.replaced.begin - 1] == '"';
  if (field.kind == ValueKind::file) {
    into.files = Completions::Files::model;
    into.needs_quotes = !is_quoted;
    return;
  }
  for (const std::string& choice : field.choices) {
    const bool is_plain = field.kind == ValueKind::boolean || is_quoted;
    into.items.push_back({choice, is_plain ? choice : fmt::format("\"{}\"", choice),
                          choice == field.fallback ? "default" : "", ""});
  }
  if (field.kind == ValueKind::vector)
    into.items.push_back({"vec3", "vec3(0, 0, 0)", "x, y, z", ""});
  if (field.kind == ValueKind::color) into.items.push_back({"rgb", "rgb(1, 1, 1)", "r, g, b", ""});
  for (const Entity& entity : outline.entities())
    if (!entity.name.empty() && entity.parent == 0 && entity.kind != EntityKind::macro)
      into.items.push_back({entity.name, entity.name, entity.type, ""});
}

}  // namespace

SourceRange word_around(std::string_view text, size_t offset) {
  auto begin = static_cast<uint32_t>(std::min(offset, text.size()));
  uint32_t end = begin;
  while (begin > 0 && is_word_character(text[begin - 1])) --begin;
  while (end < text.size() && is_word_character(text[end])) ++end;
  return {begin, end};
}

SourceRange quoted_around(std::string_view text, size_t offset) {
  constexpr std::string_view kEnds = "\"'\n<>";
  const size_t end = std::min(text.find_first_of(kEnds, offset), text.size());
  const size_t before = offset == 0 ? std::string_view::npos : text.find_last_of(kEnds, offset - 1);
  const size_t begin = before == std::string_view::npos ? 0 : before + 1;
  return {static_cast<uint32_t>(begin), static_cast<uint32_t>(end)};
}

Completions crt_completions(const Outline& outline, size_t offset) {
  const SyntaxTree& tree = outline.tree();
  Completions made{word_around(outline.text(), offset), {}};
  const int32_t object = object_at(tree, offset);
  if (object >= 0) {
    const CrtObjectWord* word = find_crt_word(text_of(outline.text(), tree[object].name));
    const int32_t attribute = attribute_at(tree, object, offset);
    const bool is_name = attribute < 0 || (!tree[attribute].value.contains(offset) &&
                                           !tree[attribute].value.is_empty());
    if (!is_name) {
      const auto* known = find_crt_attribute(word, text_of(outline.text(), tree[attribute].name));
      const std::string_view value = text_of(outline.text(), tree[attribute].value);
      if (value.starts_with('"') && tree[attribute].value.contains(offset))
        made.replaced = quoted_around(outline.text(), offset);
      if (known) add_values(outline, describe(*known), made);
      return made;
    }
    for (const CrtAttributeWord& one :
         word ? word->attributes : std::span<const CrtAttributeWord>{}) {
      bool is_there = false;
      for (int32_t k = tree[object].first_child; k >= 0; k = tree[k].next)
        is_there |=
            text_of(outline.text(), tree[k].name) == one.name && tree[k].name != made.replaced;
      if (is_there) continue;
      made.items.push_back({std::string(one.name), fmt::format("{} -> ", one.name),
                            detail_of(describe(one)), std::string(one.help)});
    }
    return made;
  }
  for (const CrtObjectWord& word : crt_words())
    made.items.push_back({std::string(word.name), fmt::format("{} {{ }}", word.name),
                          std::string(name_of(word.kind)), std::string(word.help)});
  for (const auto& [name, variable] : crt_variables(outline.text(), tree))
    if (variable.assigned > 0)
      made.items.push_back({std::string(name), std::string(name), "variable", ""});
  std::sort(made.items.begin(), made.items.end(),
            [](const Completion& a, const Completion& b) { return a.label < b.label; });
  return made;
}

std::optional<Hover> crt_hover(const Outline& outline, size_t offset) {
  const SyntaxTree& tree = outline.tree();
  for (int32_t i = tree.node_at(offset); i > 0; i = tree[i].parent) {
    const SyntaxNode& node = tree[i];
    if (!node.name.contains(offset) || node.name.is_empty()) continue;
    const std::string name(text_of(outline.text(), node.name));
    if (crt_part(node) == CrtPart::attribute) {
      const auto* object = find_crt_word(text_of(outline.text(), tree[node.parent].name));
      const CrtAttributeWord* known = find_crt_attribute(object, name);
      if (!known) return {};
      return Hover{node.name, fmt::format("{}.{}", object->name, name), detail_of(describe(*known)),
                   std::string(known->help)};
    }
    if (const CrtObjectWord* word = find_crt_word(name))
      return Hover{node.name, name, std::string(name_of(word->kind)), std::string(word->help)};
  }
  return {};
}

Completions xml_completions(const Outline& outline, size_t offset) {
  const SyntaxTree& tree = outline.tree();
  Completions made{word_around(outline.text(), offset), {}};
  const uint32_t begin = made.replaced.begin;
  if (begin > 0 && outline.text()[begin - 1] == '<') {
    add_x3d_nodes("", made);
    return made;
  }
  for (int32_t i = tree.node_at(offset); i > 0; i = tree[i].parent) {
    const SyntaxNode& node = tree[i];
    if (xml_part(node) == XmlPart::attribute && node.value.contains(offset) &&
        offset > node.name.end) {
      const std::string_view type = text_of(outline.text(), tree[node.parent].name);
      const Field field = describe_x3d(type, text_of(outline.text(), node.name), "");
      add_x3d_values(outline, type, field, made);
      if (field.kind == ValueKind::file) made.replaced = quoted_around(outline.text(), offset);
      return made;
    }
    if (xml_part(node) != XmlPart::element) continue;
    const std::string_view type = text_of(outline.text(), node.name);
    const X3dNodeType* known = find_x3d_node_type(type);
    const bool is_in_tag = offset > node.name.end && offset <= node.body.begin;
    if (known && is_in_tag) add_x3d_fields(outline, node, *known, "=''", false, made);
    return made;
  }
  return made;
}

Completions classic_completions(const Outline& outline, size_t offset) {
  const SyntaxTree& tree = outline.tree();
  const std::string_view text = outline.text();
  Completions made{word_around(text, offset), {}};
  int32_t holder = tree.node_at(offset);
  if (holder > 0 && xml_part(tree[holder]) == XmlPart::attribute) holder = tree[holder].parent;
  while (holder > 0 && !tree[holder].body.contains(static_cast<uint32_t>(offset)))
    holder = tree[holder].parent;
  const std::string_view type = holder > 0 ? text_of(text, tree[holder].name) : "";
  const X3dNodeType* known = find_x3d_node_type(type);
  const auto end = static_cast<uint32_t>(std::min(offset, text.size()));
  const ClassicPlace place = classic_place(text, {tree[holder].body.begin, end});
  if (place.is_comment) return made;
  const uint32_t begin = place.string.value_or(made.replaced.begin);
  const bool names_node = word_before(text, begin) == "USE";
  const std::string_view name =
      word_before(text, names_node || !place.list ? begin : std::min(*place.list, begin));
  if (names_node || (known && known->has_field(name))) {
    Field field = describe_x3d(type, name, "");
    if (field.kind == ValueKind::boolean) field.choices = {"FALSE", "TRUE"};
    add_x3d_values(outline, type, field, made);
    made.needs_quotes = made.files != Completions::Files::none && !place.string;
    if (place.string)
      made.replaced = {*place.string + 1,
                       std::min(static_cast<uint32_t>(text.find('"', end)), line_end(text, end))};
    return made;
  }
  if (place.string) return made;
  const bool holds_node = known && known->has_node_field(name);
  if (known && !holds_node && !place.list)
    add_x3d_fields(outline, tree[holder], *known, " ", true, made);
  if (!known || holds_node) add_x3d_nodes(" { }", made);
  return made;
}

std::optional<Hover> x3d_hover(const Outline& outline, size_t offset) {
  const SyntaxTree& tree = outline.tree();
  for (int32_t i = tree.node_at(offset); i > 0; i = tree[i].parent) {
    const SyntaxNode& node = tree[i];
    if (!node.name.contains(offset) || node.name.is_empty()) continue;
    const std::string name(text_of(outline.text(), node.name));
    if (xml_part(node) != XmlPart::attribute) {
      const X3dNodeType* type = find_x3d_node_type(name);
      if (!type) return {};
      const bool is_read = type->use == X3dNodeType::Use::read;
      return Hover{
          node.name, name,
          is_read ? std::string(name_of(x3d_entity_kind(name))) : "no effect on the picture", ""};
    }
    const std::string_view type = text_of(outline.text(), tree[node.parent].name);
    return Hover{node.name, fmt::format("{}.{}", type, name),
                 detail_of(describe_x3d(type, name, "")), ""};
  }
  return {};
}

}  // namespace tessera::edit
