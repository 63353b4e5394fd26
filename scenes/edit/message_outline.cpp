#include "scenes/edit/message_outline.h"

#include <fmt/format.h>

#include <map>

#include "scenes/edit/schema.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;

/// Fields of a list beyond these are told as the list alone.
constexpr int kMostItems = 64;

/// Makes entities and fields of the nodes of a tree. As deep as the tree is, which is bounded.
class MessageOutliner {
 public:
  MessageOutliner(std::string_view text, const SyntaxTree& tree) : text_(text), tree_(tree) {}

  std::vector<Entity> run() {
    Entity scene{.kind = EntityKind::scene, .type = "Scene"};
    scene.range = tree_[0].range;
    scene.body = tree_[0].body;
    made_.push_back(std::move(scene));
    children(0, 0, "");
    return std::move(made_);
  }

 private:
  using Counts = std::map<int, int>;

  void children(int32_t node, size_t entity, const std::string& prefix) {
    Counts counts;
    for (int32_t i = tree_[node].first_child; i >= 0; i = tree_[i].next)
      child(i, entity, prefix, counts);
  }

  void child(int32_t i, size_t entity, const std::string& prefix, Counts& counts) {
    const SyntaxNode& node = tree_[i];
    if (!node.field) return;
    if (node.kind == SyntaxKind::list) {
      if (!node.field->message_type()) add_field(i, entity, prefix + node.field->name());
      for (int32_t item = node.first_child; item >= 0; item = tree_[item].next)
        child(item, entity, prefix, counts);
      return;
    }
    std::string name = prefix + node.field->name();
    if (node.field->is_repeated()) {
      const int index = counts[node.field->number()]++;
      if (index >= kMostItems && !node.message) return;
      name += fmt::format("[{}]", index);
    }
    if (!node.message || is_vector(node.message)) {
      add_field(i, entity, std::move(name));
    } else if (entity_kind(*node.message) != EntityKind::other) {
      add_entity(i, entity, name);
    } else {
      if (made_[entity].type.empty() || node.field->containing_oneof())
        set_type(entity, node, prefix);
      children(i, entity, name + ".");
    }
  }

  void set_type(size_t entity, const SyntaxNode& node, const std::string& prefix) {
    if (prefix.empty() && node.field->real_containing_oneof())
      made_[entity].type = node.field->name();
  }

  void add_entity(int32_t i, size_t parent, const std::string& name) {
    const SyntaxNode& node = tree_[i];
    Entity entity{.parent = static_cast<int>(parent), .kind = entity_kind(*node.message)};
    const std::string& above = made_[parent].path;
    entity.path = above.empty() ? name : above + "." + name;
    entity.range = node.range;
    entity.body = node.body;
    entity.syntax = static_cast<uint32_t>(i);
    const size_t index = made_.size();
    made_.push_back(std::move(entity));
    children(i, index, "");
    Entity& made = made_[index];
    for (const Field& field : made.fields)
      if (field.name == "name" || (made.name.empty() && field.name == "file"))
        made.name = field.text;
    if (made.kind == EntityKind::node) name_node_type(index);
    if (made.type.empty()) made.type = node.message->name();
  }

  /// A node is what it holds.
  void name_node_type(size_t index) {
    std::string type = "group";
    for (const Field& field : made_[index].fields)
      if (field.name == "instance_of") type = "instance of " + field.text;
    for (size_t i = index + 1; i < made_.size(); ++i) {
      if (made_[i].parent != static_cast<int>(index)) continue;
      if (made_[i].kind == EntityKind::shape) type = made_[i].type;
      if (made_[i].kind == EntityKind::light) type = "light";
    }
    made_[index].type = type;
  }

  void add_field(int32_t i, size_t entity, std::string name) {
    const SyntaxNode& node = tree_[i];
    Field field = describe(*node.field, holder_of(node));
    field.name = std::move(name);
    field.is_present = true;
    field.range = node.range;
    field.value = node.value;
    if (node.kind == SyntaxKind::list) field.kind = ValueKind::list;
    field.text = shown_value(text_, tree_, i);
    made_[entity].fields.push_back(std::move(field));
  }

  const pb::FieldDescriptor* holder_of(const SyntaxNode& node) const {
    return node.parent >= 0 ? tree_[node.parent].field : nullptr;
  }

  std::string_view text_;
  const SyntaxTree& tree_;
  std::vector<Entity> made_;
};

/// Adds the fields of a message that the text may have and does not, those of the members of its
/// oneofs that are not chosen left out.
class MissingFields {
 public:
  MissingFields(const Outline& outline, const Entity& entity) : outline_(outline) {
    for (const Field& field : entity.fields) present_[field.name] = &field;
  }

  void add(const pb::Descriptor& type, int32_t node, const std::string& prefix, int depth,
           const pb::FieldDescriptor* holder = nullptr) {
    constexpr int kDeep = 4;
    if (depth > kDeep) return;
    for (int i = 0; i < type.field_count(); ++i) {
      const pb::FieldDescriptor& field = *type.field(i);
      const auto there =
          node >= 0 ? occurrences(outline_.tree(), node, &field) : std::vector<int32_t>{};
      if (field.is_repeated()) {
        several(field, prefix);
      } else if (field.real_containing_oneof() && there.empty()) {
        continue;
      } else if (const pb::Descriptor* inside = field.message_type();
                 inside && !is_vector(inside)) {
        if (entity_kind(*inside) == EntityKind::other)
          add(*inside, there.empty() ? -1 : there.front(), prefix + field.name() + ".", depth + 1,
              &field);
      } else {
        one(field, prefix, holder);
      }
    }
  }
  std::vector<Field> fields;

 private:
  void one(const pb::FieldDescriptor& field, const std::string& prefix,
           const pb::FieldDescriptor* holder) {
    if (const auto found = present_.find(prefix + field.name()); found != present_.end()) {
      fields.push_back(*found->second);
    } else {
      fields.push_back(describe(field, holder));
      fields.back().name = prefix + field.name();
    }
  }

  void several(const pb::FieldDescriptor& field, const std::string& prefix) {
    const std::string name = prefix + field.name();
    if (const auto list = present_.find(name); list != present_.end())
      fields.push_back(*list->second);
    for (int i = 0; i < kMostItems; ++i) {
      const auto found = present_.find(fmt::format("{}[{}]", name, i));
      if (found == present_.end()) return;
      fields.push_back(*found->second);
    }
  }

  const Outline& outline_;
  std::map<std::string, const Field*> present_;
};

}  // namespace

std::vector<Entity> message_entities(std::string_view text, const SyntaxTree& tree) {
  return MessageOutliner(text, tree).run();
}

std::vector<Field> all_message_fields(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const auto node = static_cast<int32_t>(asked.syntax);
  const pb::Descriptor* type = outline.tree()[node].message;
  if (!type) return asked.fields;
  MissingFields all(outline, asked);
  all.add(*type, node, "", 0);
  return std::move(all.fields);
}

std::string shown_value(std::string_view text, const SyntaxTree& tree, int32_t i) {
  const SyntaxNode& node = tree[i];
  if (node.kind == SyntaxKind::block && is_vector(node.message)) {
    std::string shown;
    for (int part = 0; part < node.message->field_count(); ++part) {
      const auto found = occurrences(tree, i, node.message->field(part));
      if (part > 0) shown += ' ';
      shown += found.empty() ? "0" : std::string(text_of(text, tree[found.back()].value));
    }
    return shown;
  }
  const std::string_view value = text_of(text, node.value);
  constexpr size_t kLongest = 4096;
  if (node.kind == SyntaxKind::list) return std::string(value.substr(0, kLongest));
  const bool is_quoted = value.starts_with('"') || value.starts_with('\'');
  return is_quoted ? unquote(value) : std::string(value);
}

std::vector<int32_t> occurrences(const SyntaxTree& tree, int32_t parent,
                                 const pb::FieldDescriptor* field) {
  std::vector<int32_t> found;
  for (int32_t i = tree[parent].first_child; i >= 0; i = tree[i].next) {
    if (tree[i].field != field || tree[i].kind == SyntaxKind::note) continue;
    if (tree[i].kind != SyntaxKind::list) {
      found.push_back(i);
      continue;
    }
    for (int32_t item = tree[i].first_child; item >= 0; item = tree[item].next)
      found.push_back(item);
  }
  return found;
}

}  // namespace tessera::edit
