#include "scenes/edit/message_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_outline.h"
#include "scenes/edit/message_path.h"
#include "scenes/edit/message_writer.h"
#include "scenes/edit/schema.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;
using Type = pb::FieldDescriptor;

std::optional<Refusal> check(const Type& field, const Type* holder, std::string_view value) {
  const Field described = describe(field, holder);
  if (auto refusal = check_value(described, value)) return refusal;
  if (field.cpp_type() != Type::CPPTYPE_FLOAT) return {};
  const auto number = typed_number(trimmed(value));
  if (number && std::abs(*number) <= double{std::numeric_limits<float>::max()}) return {};
  return Refusal{fmt::format("'{}'", value), "a number of at most 3.4e38", {}};
}

/// What a field's value is written as, or why it is not.
struct Drafted {
  Draft draft;
  std::optional<Refusal> refusal;
};

Drafted draft_value(const MessageWriter& writer, const Type& field, std::string_view value,
                    const Type* holder = nullptr) {
  Drafted made{{&field, "", {}}, {}};
  const pb::Descriptor* type = field.message_type();
  if (!type) {
    made.refusal = check(field, holder, value);
    if (!made.refusal) made.draft.literal = writer.literal(field, value, "");
    return made;
  }
  if (is_input(type)) {
    Drafted inside = draft_value(writer, *type->field(0), value, &field);
    made.refusal = std::move(inside.refusal);
    made.draft.parts.push_back(std::move(inside.draft));
    return made;
  }
  const std::vector<std::string> parts = typed_parts(value);
  if (!is_vector(type) || static_cast<int>(parts.size()) != type->field_count()) {
    made.refusal =
        Refusal{value.empty() ? "nothing" : fmt::format("'{}'", value),
                is_vector(type) ? fmt::format("{} numbers between blanks", type->field_count())
                                : fmt::format("one of its fields: {}", field_list(*type)),
                {}};
    return made;
  }
  for (int i = 0; i < type->field_count() && !made.refusal; ++i) {
    const std::string& part = parts[static_cast<size_t>(i)];
    made.refusal = check(*type->field(i), nullptr, part);
    if (made.refusal || typed_number(part) == 0.0) continue;
    made.draft.parts.push_back({type->field(i), writer.literal(*type->field(i), part, ""), {}});
  }
  return made;
}

/// `draft` inside messages of the fields in `path` from `from` on.
Draft wrapped(const std::vector<const Type*>& path, size_t from, Draft draft) {
  for (size_t i = path.size(); i-- > from;) draft = Draft{path[i], "", {std::move(draft)}};
  return draft;
}

Change set_scalar(const Outline& outline, const MessageWriter& writer, int32_t node,
                  std::string_view value) {
  const SyntaxNode& there = outline.tree()[node];
  const SyntaxNode* above = there.parent >= 0 ? &outline.tree()[there.parent] : nullptr;
  Change change;
  if (auto refusal = check(*there.field, above ? above->field : nullptr, value)) {
    refusal->range = there.value;
    change.refusal = std::move(refusal);
    return change;
  }
  const std::string_view old = text_of(outline.text(), there.value);
  std::string literal = writer.literal(*there.field, value, old);
  if (literal == old) return change;
  if (old.empty()) literal = " " + literal;
  const bool is_quoted = old.starts_with('"') || old.starts_with('\'');
  // Escapes that say the same are kept.
  if (is_quoted && there.is_closed && unquote(old) == value) return change;
  change.edits.push_back({there.value, std::move(literal)});
  return change;
}

Change set_vector(const Outline& outline, const MessageWriter& writer, int32_t node,
                  std::string_view value) {
  const SyntaxTree& tree = outline.tree();
  const pb::Descriptor& type = *tree[node].message;
  const std::vector<std::string> parts = typed_parts(value);
  if (static_cast<int>(parts.size()) != type.field_count())
    return refuse(value.empty() ? "nothing" : fmt::format("'{}'", value),
                  fmt::format("{} numbers between blanks", type.field_count()), tree[node].value);
  Change change;
  std::vector<Draft> missing;
  for (int i = 0; i < type.field_count(); ++i) {
    const std::string& part = parts[static_cast<size_t>(i)];
    const auto there = occurrences(tree, node, type.field(i));
    if (!there.empty()) {
      Change one = set_scalar(outline, writer, there.back(), part);
      if (one.refusal) return one;
      change.edits.insert(change.edits.end(), one.edits.begin(), one.edits.end());
      continue;
    }
    if (auto refusal = check(*type.field(i), nullptr, part)) {
      change.refusal = std::move(refusal);
      return change;
    }
    if (typed_number(part) == 0.0) continue;
    missing.push_back({type.field(i), writer.literal(*type.field(i), part, ""), {}});
  }
  if (!missing.empty()) {
    const auto inserted = writer.insert(node, missing);
    change.edits.insert(change.edits.end(), inserted.begin(), inserted.end());
  }
  std::stable_sort(
      change.edits.begin(), change.edits.end(), [](const TextEdit& a, const TextEdit& b) {
        return std::pair(a.range.begin, a.range.end) < std::pair(b.range.begin, b.range.end);
      });
  return change;
}

/// Another member of the field's oneof that the text has at `node`; -1: none.
int32_t rival(const SyntaxTree& tree, int32_t node, const Type& field) {
  const pb::OneofDescriptor* group = field.real_containing_oneof();
  if (!group) return -1;
  for (int32_t i = tree[node].first_child; i >= 0; i = tree[i].next)
    if (tree[i].field && tree[i].field != &field && tree[i].field->containing_oneof() == group)
      return i;
  return -1;
}

Change insert_missing(const Outline& outline, const MessageWriter& writer, const MessagePath& path,
                      Draft draft) {
  const SyntaxTree& tree = outline.tree();
  const Type& first = path.missing.empty() ? *draft.field : *path.missing.front();
  if (const int32_t other = rival(tree, path.node, first); other >= 0)
    return refuse(fmt::format("{} is there", tree[other].field->name()),
                  fmt::format("a scene without it before {} is set", first.name()),
                  tree[other].range);
  Change change;
  change.edits = writer.insert(path.node, {wrapped(path.missing, 0, std::move(draft))});
  return change;
}

/// Names that are taken, by the type of the message that has them.
std::map<const pb::Descriptor*, std::vector<std::string>> taken_names(const Outline& outline) {
  std::map<const pb::Descriptor*, std::vector<std::string>> names;
  for (const Entity& entity : outline.entities())
    if (const pb::Descriptor* type = outline.tree()[static_cast<int32_t>(entity.syntax)].message)
      if (!entity.name.empty()) names[type].push_back(entity.name);
  return names;
}

}  // namespace

Change refuse(std::string found, std::string expected, SourceRange range) {
  Change change;
  change.refusal = Refusal{std::move(found), std::move(expected), range};
  return change;
}

Change set_message_field(const Outline& outline, int entity, std::string_view field,
                         std::string_view value) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const MessageWriter writer(outline);
  MessagePath path = find_field(outline.tree(), static_cast<int32_t>(asked.syntax), field);
  if (path.refusal) return refuse(path.refusal->found, path.refusal->expected);
  while (path.leaf >= 0 && is_input(outline.tree()[path.leaf].message)) {
    const Type* inner = outline.tree()[path.leaf].message->field(0);
    const auto there = occurrences(outline.tree(), path.leaf, inner);
    path.node = path.leaf;
    path.field = inner;
    path.leaf = there.empty() ? -1 : there.back();
  }
  if (path.leaf >= 0) {
    const SyntaxNode& there = outline.tree()[path.leaf];
    if (there.kind == SyntaxKind::scalar && !path.field->message_type())
      return set_scalar(outline, writer, path.leaf, value);
    if (is_vector(there.message)) return set_vector(outline, writer, path.leaf, value);
    return refuse(fmt::format("{} is a message", field),
                  fmt::format("one of its fields: {}",
                              there.message ? field_list(*there.message) : std::string()),
                  there.range);
  }
  const Type* holder = path.missing.empty() ? outline.tree()[path.node].field : path.missing.back();
  Drafted drafted = draft_value(writer, *path.field, value, holder);
  if (drafted.refusal) {
    Change change;
    change.refusal = std::move(drafted.refusal);
    return change;
  }
  return insert_missing(outline, writer, path, std::move(drafted.draft));
}

Change reset_message_field(const Outline& outline, int entity, std::string_view field) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const MessagePath path = find_field(outline.tree(), static_cast<int32_t>(asked.syntax), field);
  if (path.refusal) return refuse(path.refusal->found, path.refusal->expected);
  Change change;
  if (path.leaf >= 0) change.edits.push_back(MessageWriter(outline).remove(path.leaf));
  return change;
}

Change remove_message(const Outline& outline, int entity) {
  if (entity == 0) return refuse("the scene itself", "a part of it");
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  Change change;
  change.edits.push_back(MessageWriter(outline).remove(static_cast<int32_t>(asked.syntax)));
  return change;
}

Change duplicate_message(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const auto node = static_cast<int32_t>(asked.syntax);
  const SyntaxNode& there = outline.tree()[node];
  if (entity == 0 || !there.field || !there.field->is_repeated())
    return refuse(fmt::format("{}, of which a scene has one", name_of(asked.kind)),
                  "what may be there several times", asked.range);
  if (!there.is_closed)
    return refuse("an entity that is never closed", "its closing bracket", asked.range);
  auto taken = taken_names(outline);
  std::vector<TextEdit> renamed;
  const MessageWriter writer(outline);
  for (size_t i = static_cast<size_t>(entity);
       i < outline.entities().size() && asked.range.contains(outline.entities()[i].range); ++i) {
    const Entity& inner = outline.entities()[i];
    const SyntaxNode& message = outline.tree()[static_cast<int32_t>(inner.syntax)];
    const auto name = std::find_if(inner.fields.begin(), inner.fields.end(),
                                   [](const Field& f) { return f.name == "name"; });
    if (name == inner.fields.end() || name->text.empty()) continue;
    auto& names = taken[message.message];
    std::string made = free_name(name->text, names, " ");
    names.push_back(made);
    const std::string_view old = text_of(outline.text(), name->value);
    renamed.push_back({{name->value.begin - asked.range.begin, name->value.end - asked.range.begin},
                       writer.literal(*message.message->FindFieldByName("name"), made, old)});
  }
  std::sort(renamed.begin(), renamed.end(),
            [](const TextEdit& a, const TextEdit& b) { return a.range.begin < b.range.begin; });
  Change change;
  change.edits.push_back(
      writer.insert_behind(node, apply_edits(text_of(outline.text(), asked.range), renamed)));
  return change;
}

Change add_message(const Outline& outline, int parent, const EntityTemplate& made) {
  const Entity& holder = outline.entities()[static_cast<size_t>(parent)];
  const MessageWriter writer(outline);
  MessagePath path = find_field(outline.tree(), static_cast<int32_t>(holder.syntax), made.type);
  if (path.refusal) return refuse(path.refusal->found, path.refusal->expected);
  if (!path.field->message_type())
    return refuse(fmt::format("{} is a value", made.type), "a message");
  if (!path.field->is_repeated() && path.leaf >= 0)
    return refuse(fmt::format("{} is there", made.type), "a place for it",
                  outline.tree()[path.leaf].range);
  Draft draft{path.field, "", {}};
  auto taken = taken_names(outline);
  auto fields = made.fields;
  if (made.position) {
    if (made.type != "nodes" && made.type != "includes")
      return refuse(fmt::format("a place for {}", made.name), "one for a node or a file");
    fields.emplace_back("transform.steps.translate", written_position(made));
  }
  for (const auto& [name, value] : fields) {
    std::string given = value;
    if (name == "name") given = free_name(value, taken[path.field->message_type()], " ");
    const DraftPlace place = find_draft(draft, name);
    if (place.refusal) return refuse(place.refusal->found, place.refusal->expected);
    Drafted drafted = draft_value(writer, *place.field, given, place.holder->field);
    if (drafted.refusal) return refuse(drafted.refusal->found, drafted.refusal->expected);
    place.holder->parts.push_back(std::move(drafted.draft));
  }
  return insert_missing(outline, writer, path, std::move(draft));
}

}  // namespace tessera::edit
