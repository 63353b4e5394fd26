#include <fmt/format.h>

#include <map>

#include "scenes/edit/message_outline.h"
#include "scenes/edit/x3d_edit.h"
#include "scenes/edit/x3d_units.h"
#include "scenes/edit/x3d_words.h"
#include "scenes/edit/xml_syntax.h"
#include "scenes/formats/x3d/document/x3d_nodes.h"

namespace tessera::edit {
namespace {

/// What begins and ends a value of strings: `"a.jpg" "b.jpg"` shows the first.
std::string first_string(const std::string& value) {
  const size_t open = value.find('"');
  if (open == std::string::npos) return value;
  return value.substr(open + 1, value.find('"', open + 1) - open - 1);
}

class XmlOutliner {
 public:
  XmlOutliner(std::string_view text, const SyntaxTree& tree, bool is_classic)
      : text_(text),
        tree_(tree),
        is_classic_(is_classic),
        units_(x3d_units(text, tree, is_classic)) {}

  std::vector<Entity> run() {
    count_uses();
    Entity scene{.kind = EntityKind::scene, .type = "X3D"};
    scene.range = scene.body = tree_[0].range;
    made_.push_back(std::move(scene));
    // Parents stand before their children in the tree, and so do entities.
    std::vector<int> entity_of(static_cast<size_t>(tree_.size()), 0);
    std::vector<std::map<std::string_view, int>> counts(1);
    for (int32_t i = 1; i < tree_.size(); ++i) {
      const auto parent = static_cast<size_t>(entity_of[static_cast<size_t>(tree_[i].parent)]);
      if (xml_part(tree_[i]) == XmlPart::attribute) {
        add_field(made_[parent], i);
        continue;
      }
      const std::string_view type = text_of(text_, tree_[i].name);
      entity_of[static_cast<size_t>(i)] = static_cast<int>(made_.size());
      add_entity(i, parent, counts[parent][type]++);
      counts.emplace_back();
    }
    return std::move(made_);
  }

 private:
  void count_uses() {
    for (int32_t i = 1; i < tree_.size(); ++i)
      if (xml_part(tree_[i]) == XmlPart::attribute && text_of(text_, tree_[i].name) == "USE")
        ++uses_[text_of(text_, tree_[i].body)];
  }

  void add_entity(int32_t i, size_t parent, int index) {
    const SyntaxNode& node = tree_[i];
    Entity entity{.parent = static_cast<int>(parent)};
    entity.type = text_of(text_, node.name);
    entity.kind = x3d_entity_kind(entity.type);
    const std::string& above = made_[parent].path;
    entity.path = fmt::format("{}{}{}[{}]", above, above.empty() ? "" : ".", entity.type, index);
    entity.range = node.range;
    entity.body = node.body;
    entity.syntax = static_cast<uint32_t>(i);
    made_.push_back(std::move(entity));
  }

  void add_field(Entity& entity, int32_t i) {
    const SyntaxNode& node = tree_[i];
    const std::string_view name = text_of(text_, node.name);
    const std::string_view words = text_of(text_, node.body);
    const bool is_string = is_classic_ && words.starts_with('"');
    const std::string value = is_string     ? unquote(words)
                              : is_classic_ ? std::string(words)
                                            : unescape_xml(words);
    Field field = in_units(describe_x3d(entity.type, name, value), units_);
    field.is_present = true;
    field.range = node.range;
    field.value = node.body;
    field.syntax = i;
    field.text = field.kind == ValueKind::file && !is_classic_ ? first_string(value) : value;
    if (is_classic_ && field.kind == ValueKind::boolean) field.choices = {"FALSE", "TRUE"};
    if (is_classic_ && words.starts_with("IS ")) field.locked = "the value of a prototype's field";
    if (name == "DEF") {
      entity.name = value;
      if (const auto used = uses_.find(text_of(text_, node.body)); used != uses_.end())
        field.uses = used->second + 1;
    }
    if (name == "USE" ||
        (entity.name.empty() && entity.kind == EntityKind::include && name == "url"))
      entity.name = field.text;
    const X3dNodeType* type = find_x3d_node_type(entity.type);
    if (type && type->use == X3dNodeType::Use::ignored)
      field.locked = fmt::format("{} has no effect on the picture", entity.type);
    entity.fields.push_back(std::move(field));
  }

  std::string_view text_;
  const SyntaxTree& tree_;
  bool is_classic_;
  X3dUnits units_;
  std::map<std::string_view, int> uses_;
  std::vector<Entity> made_;
};

}  // namespace

std::vector<Entity> xml_entities(std::string_view text, const SyntaxTree& tree, bool is_classic) {
  return XmlOutliner(text, tree, is_classic).run();
}

std::vector<Field> all_xml_fields(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  std::vector<Field> all = asked.fields;
  const X3dUnits units = x3d_units(outline);
  const X3dNodeType* type = find_x3d_node_type(asked.type);
  std::string_view rest = type ? type->fields : std::string_view{};
  while (!rest.empty()) {
    const size_t blank = rest.find(' ');
    const std::string_view name = rest.substr(0, blank);
    rest.remove_prefix(blank == std::string_view::npos ? rest.size() : blank + 1);
    bool is_there = name.empty();
    for (const Field& field : asked.fields) is_there |= field.name == name;
    if (!is_there) all.push_back(in_units(describe_x3d(asked.type, name, ""), units));
  }
  return all;
}

}  // namespace tessera::edit
