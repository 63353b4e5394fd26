#include "scenes/edit/gltf_edit.h"

#include <fmt/format.h>

#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/message_outline.h"

namespace tessera::edit {
namespace {

EntityKind kind_of(std::string_view list) {
  constexpr std::pair<std::string_view, EntityKind> kKinds[] = {
      {"cameras", EntityKind::camera},   {"materials", EntityKind::material},
      {"textures", EntityKind::texture}, {"images", EntityKind::texture},
      {"nodes", EntityKind::node},       {"meshes", EntityKind::shape},
      {"scenes", EntityKind::group}};
  for (const auto& [name, kind] : kKinds)
    if (name == list) return kind;
  return EntityKind::other;
}

bool is_data(std::string_view list) {
  return list == "accessors" || list == "buffers" || list == "bufferViews";
}

class GltfOutliner {
 public:
  GltfOutliner(std::string_view text, const SyntaxTree& tree) : text_(text), tree_(tree) {}

  std::vector<Entity> run() {
    Entity scene{.kind = EntityKind::scene, .type = "glTF"};
    scene.range = scene.body = tree_[0].range;
    made_.push_back(std::move(scene));
    for (int32_t i = tree_[0].first_child; i >= 0; i = tree_[i].next) {
      if (tree_[i].kind != SyntaxKind::list) continue;
      int index = 0;
      for (int32_t k = tree_[i].first_child; k >= 0; k = tree_[k].next)
        if (tree_[k].kind == SyntaxKind::block) item(k, text_of(text_, tree_[i].name), index++);
    }
    return std::move(made_);
  }

 private:
  void item(int32_t i, std::string_view list, int index) {
    Entity entity{.parent = 0, .kind = kind_of(list)};
    entity.type = list;
    entity.path = fmt::format("{}[{}]", list, index);
    entity.range = tree_[i].range;
    entity.body = tree_[i].body;
    entity.syntax = static_cast<uint32_t>(i);
    fields(entity, i, "", is_data(list));
    for (const Field& field : entity.fields)
      if (field.name == "name") entity.name = field.text;
    made_.push_back(std::move(entity));
  }

  /// As deep as the tree is, which is bounded.
  void fields(Entity& entity, int32_t i, const std::string& prefix, bool is_locked) {
    int index = 0;
    for (int32_t k = tree_[i].first_child; k >= 0; k = tree_[k].next) {
      const SyntaxNode& node = tree_[k];
      const std::string name = node.name.is_empty() ? fmt::format("{}[{}]", prefix, index++)
                               : prefix.empty()
                                   ? std::string(text_of(text_, node.name))
                                   : fmt::format("{}.{}", prefix, text_of(text_, node.name));
      if (node.kind != SyntaxKind::scalar) {
        fields(entity, k, name, is_locked);
        continue;
      }
      Field field;
      field.name = name;
      field.range = node.range;
      field.value = node.value;
      field.syntax = k;
      field.text = shown_value(text_, tree_, k);
      const std::string_view value = text_of(text_, node.value);
      const bool is_boolean = value == "true" || value == "false";
      field.kind = is_boolean               ? ValueKind::boolean
                   : value.starts_with('"') ? (name == "uri" ? ValueKind::file : ValueKind::text)
                                            : ValueKind::number;
      if (is_boolean) field.choices = {"false", "true"};
      if (is_locked) field.locked = "data of a mesh are shown and not set";
      entity.fields.push_back(std::move(field));
    }
  }

  std::string_view text_;
  const SyntaxTree& tree_;
  std::vector<Entity> made_;
};

}  // namespace

std::vector<Entity> gltf_entities(std::string_view text, const SyntaxTree& tree) {
  return GltfOutliner(text, tree).run();
}

Change set_gltf_field(const Outline& outline, int entity, std::string_view name,
                      std::string_view value) {
  for (const Field& field : outline.entities()[static_cast<size_t>(entity)].fields) {
    if (field.name != name) continue;
    if (!field.locked.empty()) return refuse(field.text.substr(0, 40), field.locked, field.value);
    Change change;
    if (auto refusal = check_value(field, value)) {
      refusal->range = field.value;
      change.refusal = std::move(refusal);
      return change;
    }
    if (field.text == value) return change;
    const bool is_text = field.kind == ValueKind::text || field.kind == ValueKind::file;
    const std::string_view word = trimmed(value);
    std::string made = is_text                           ? quote(value, '"', true)
                       : field.kind == ValueKind::number ? strict_number(word)
                                                         : std::string(word);
    if (field.value.is_empty()) made = " " + made;
    change.edits.push_back({field.value, std::move(made)});
    return change;
  }
  return refuse(fmt::format("'{}' is not in the text", name), "a value that is there");
}

}  // namespace tessera::edit
