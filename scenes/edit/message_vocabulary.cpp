#include "scenes/edit/message_vocabulary.h"

#include <fmt/format.h>

#include "scenes/edit/literal.h"
#include "scenes/edit/message_outline.h"
#include "scenes/edit/schema.h"
#include "scenes/edit/word_vocabulary.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;
using Type = pb::FieldDescriptor;

std::string insert_text(const Type& field, bool is_json) {
  const std::string name = is_json ? field.json_name() : field.name();
  if (!is_json) return field.message_type() ? name + " { }" : name + ": ";
  const std::string value = field.message_type() ? "{}" : "";
  return field.is_repeated() ? fmt::format("\"{}\": [{}]", name, value)
                             : fmt::format("\"{}\": {}", name, value);
}

std::string detail_of_type(const Type& field) {
  if (field.message_type() && !is_vector(field.message_type()) && !is_input(field.message_type()))
    return field.message_type()->name();
  return detail_of(describe(field));
}

/// The kind of entity that a reference names.
EntityKind referred(const Type& field) {
  if (field.name() == "texture" || field.name() == "normal_map") return EntityKind::texture;
  return field.name() == "instance_of" ? EntityKind::object : EntityKind::material;
}

void add_fields(const Outline& outline, int32_t message, Completions& into) {
  const SyntaxTree& tree = outline.tree();
  const bool is_json = outline.language() == Language::json;
  const pb::Descriptor& type = *tree[message].message;
  for (int i = 0; i < type.field_count(); ++i) {
    const Type& field = *type.field(i);
    bool is_there = false;
    for (int32_t k = tree[message].first_child; k >= 0; k = tree[k].next) {
      const Type* other = tree[k].field;
      if (!other || tree[k].range.contains(into.replaced)) continue;
      const bool is_rival = field.real_containing_oneof() &&
                            other->containing_oneof() == field.real_containing_oneof();
      is_there |= (other == &field && (is_json || !field.is_repeated())) || is_rival;
    }
    if (is_there) continue;
    into.items.push_back({is_json ? field.json_name() : field.name(), insert_text(field, is_json),
                          detail_of_type(field), std::string(comment_on(field.full_name()))});
  }
}

void add_values(const Outline& outline, const Type& field, bool is_quoted, Completions& into) {
  const Field described = describe(field);
  const bool needs_quotes =
      !is_quoted && (field.cpp_type() == Type::CPPTYPE_STRING ||
                     (field.enum_type() && outline.language() == Language::json));
  const auto add = [&](const std::string& label, std::string help) {
    into.items.push_back({label, needs_quotes ? fmt::format("\"{}\"", label) : label,
                          label == described.fallback ? "default" : "", std::move(help)});
  };
  for (const std::string& choice : described.choices) {
    const std::string name =
        field.enum_type() ? fmt::format("{}.{}", field.enum_type()->full_name(), choice) : "";
    add(choice, std::string(comment_on(name)));
  }
  if (described.kind == ValueKind::file) {
    const bool is_picture = field.containing_type()->name() == "Image";
    into.files = is_picture ? Completions::Files::picture : Completions::Files::model;
    into.needs_quotes = needs_quotes;
  }
  if (described.kind != ValueKind::reference) return;
  for (const Entity& entity : outline.entities())
    if (entity.kind == referred(field) && !entity.name.empty()) add(entity.name, entity.type);
}

}  // namespace

std::string detail_of(const Field& field) {
  std::string text(name_of(field.kind));
  if (!field.unit.empty()) text += fmt::format(" in {}", field.unit);
  if (const std::string limits = field.limits.str(); !limits.empty()) text += ", " + limits;
  if (!field.fallback.empty()) text += "; default " + field.fallback;
  return text;
}

Completions message_completions(const Outline& outline, size_t offset) {
  const SyntaxTree& tree = outline.tree();
  Completions made{word_around(outline.text(), offset), {}};
  int32_t i = tree.node_at(offset);
  // Of a field, its value is asked for behind its name.
  while (i > 0) {
    const SyntaxNode& node = tree[i];
    const bool is_inside = node.kind == SyntaxKind::block && node.body.begin <= offset &&
                           (offset <= node.body.end || !node.is_closed);
    if (is_inside) break;
    if (node.kind == SyntaxKind::scalar && offset > node.name.end && node.field) {
      const std::string_view value = text_of(outline.text(), node.value);
      const bool is_quoted = value.starts_with('"') || value.starts_with('\'');
      if (is_quoted) made.replaced = node.body;
      add_values(outline, *node.field, is_quoted, made);
      return made;
    }
    i = node.parent;
  }
  // A value that is still to be typed stands behind the last field's colon.
  for (int32_t k = tree[i].first_child; k >= 0; k = tree[k].next) {
    const SyntaxNode& node = tree[k];
    const bool waits = node.kind == SyntaxKind::scalar && node.value.is_empty() &&
                       node.range.end <= offset &&
                       (node.next < 0 || tree[node.next].range.begin > offset);
    if (!waits || !node.field) continue;
    add_values(outline, *node.field, false, made);
    return made;
  }
  if (tree[i].message) {
    if (outline.language() == Language::json && made.replaced.begin > 0 &&
        outline.text()[made.replaced.begin - 1] == '"') {
      --made.replaced.begin;
      if (made.replaced.end < outline.text().size() && outline.text()[made.replaced.end] == '"')
        ++made.replaced.end;
    }
    add_fields(outline, i, made);
  }
  return made;
}

std::optional<Hover> message_hover(const Outline& outline, size_t offset) {
  const SyntaxTree& tree = outline.tree();
  for (int32_t i = tree.node_at(offset); i > 0; i = tree[i].parent) {
    const SyntaxNode& node = tree[i];
    if (!node.field) continue;
    const Type& field = *node.field;
    if (node.name.contains(offset) && !node.name.is_empty()) {
      const std::string title = fmt::format("{}.{}", field.containing_type()->name(), field.name());
      std::string help(comment_on(field.full_name()));
      if (help.empty() && field.message_type())
        help = comment_on(field.message_type()->full_name());
      return Hover{node.name, title, detail_of_type(field), std::move(help)};
    }
    if (node.kind == SyntaxKind::scalar && node.value.contains(offset) && field.enum_type()) {
      const std::string value = shown_value(outline.text(), tree, i);
      return Hover{node.value, value, field.name(),
                   std::string(comment_on(field.enum_type()->full_name() + "." + value))};
    }
    if (node.kind == SyntaxKind::block) break;
  }
  return {};
}

}  // namespace tessera::edit
