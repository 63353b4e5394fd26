#include "studio/source_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "studio/unit_positions.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

constexpr const char* kSceneId = "scene";
/// Of an outline: some 10 MiB.
constexpr size_t kMostEntities = 50'000;

std::pair<size_t, size_t> units(edit::SourceRange range, const Document& document) {
  return {document.offset_of_text_byte(range.begin), document.offset_of_text_byte(range.end)};
}

void set_text(Json& json, const char* name, const std::string& text) {
  if (!text.empty()) json[name] = text;
}

Json limit(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

}  // namespace

EntityIds::EntityIds(const edit::Outline& outline) {
  for (size_t i = 0; i < outline.entities().size(); ++i) {
    const std::string path = i == 0 ? kSceneId : outline.entities()[i].path;
    std::string id = path;
    for (int twin = 2; !entities_.emplace(id, static_cast<int>(i)).second; ++twin)
      id = fmt::format("{}#{}", path, twin);
    ids_.push_back(std::move(id));
  }
}

int EntityIds::find(const std::string& id) const {
  const auto at = entities_.find(id);
  return at == entities_.end() ? -1 : at->second;
}

Json outline_json(const edit::Outline& outline, const EntityIds& ids) {
  const std::span told =
      std::span(outline.entities()).first(std::min(outline.entities().size(), kMostEntities));
  std::vector<uint32_t> bytes;
  for (const edit::Entity& entity : told) {
    bytes.push_back(entity.range.begin);
    bytes.push_back(entity.range.end);
  }
  const UnitPositions positions(outline.text(), std::move(bytes));
  Json entities = Json::array();
  for (size_t i = 0; i < told.size(); ++i) {
    const edit::Entity& entity = told[i];
    const auto& begin = positions.at(entity.range.begin);
    const auto& end = positions.at(entity.range.end);
    Json json{{"id", ids.of(static_cast<int>(i))},
              {"parent", entity.parent < 0 ? Json() : Json(ids.of(entity.parent))},
              {"kind", edit::name_of(entity.kind)},
              {"name", entity.name},
              {"type", entity.type},
              {"line", begin.line},
              {"column", begin.column},
              {"end_line", end.line},
              {"end_column", end.column},
              {"from", begin.offset},
              {"to", end.offset}};
    for (const edit::Field& field : entity.fields) {
      if (field.kind != edit::ValueKind::file) continue;
      json["target"] = field.text;
      break;
    }
    entities.push_back(std::move(json));
  }
  Json templates = Json::array();
  for (const edit::EntityTemplate& made : edit::entity_templates(outline.language()))
    templates.push_back({{"name", made.name}, {"type", made.type}});
  return {{"entities", std::move(entities)},
          {"truncated", told.size() < outline.entities().size()},
          {"templates", std::move(templates)}};
}

Json field_json(const edit::Field& field, const Document& document) {
  // Where a variable stands for the value, its literal is what is set, and what is jumped to.
  const auto [from, to] = units(field.literal.is_empty() ? field.value : field.literal, document);
  Json json{{"name", field.name}, {"kind", edit::name_of(field.kind)},
            {"text", field.text}, {"from", from},
            {"to", to},           {"present", field.is_present}};
  set_text(json, "default", field.fallback);
  set_text(json, "unit", field.unit);
  set_text(json, "help", field.help);
  set_text(json, "locked", field.locked);
  if (field.limits.least || field.limits.most) {
    json["range"] = {limit(field.limits.least), limit(field.limits.most)};
    json["open"] = {field.limits.above_least, field.limits.below_most};
  }
  if (!field.choices.empty()) json["choices"] = field.choices;
  if (field.uses > 1) json["uses"] = field.uses;
  return json;
}

Json placement_json(const edit::WrittenPlacement& read, const edit::Outline& outline) {
  const edit::Placement& placement = read.placement;
  Json json;
  json["placement"] = {{"file", placement.file},         {"material", placement.material},
                       {"position", placement.position}, {"rotation", placement.rotation},
                       {"scale", placement.scale},       {"flip", placement.flip}};
  if (read.has_material) {
    Json& materials = json["materials"] = Json::array();
    for (const edit::Entity& entity : outline.entities())
      if (entity.kind == edit::EntityKind::material && !entity.name.empty())
        materials.push_back(entity.name);
  }
  set_text(json, "locked", read.locked);
  return json;
}

Json changes_json(const std::vector<edit::TextEdit>& edits, const Document& document) {
  Json changes = Json::array();
  for (const edit::TextEdit& edit : edits) {
    const auto [from, to] = units(edit.range, document);
    changes.push_back({from, to, edit.text});
  }
  return changes;
}

Json completions_json(const edit::Completions& completions, const Document& document) {
  const auto [from, to] = units(completions.replaced, document);
  Json items = Json::array();
  for (const edit::Completion& item : completions.items) {
    Json json{{"label", item.label}, {"insert", item.insert}};
    set_text(json, "detail", item.detail);
    set_text(json, "help", item.help);
    items.push_back(std::move(json));
  }
  Json json{{"from", from}, {"to", to}, {"items", std::move(items)}};
  using Files = edit::Completions::Files;
  if (completions.files == Files::none) return json;
  json["files"] = completions.files == Files::picture ? "picture" : "model";
  json["quoted"] = completions.needs_quotes;
  return json;
}

Json hover_json(const edit::Hover& hover, const Document& document) {
  const auto [from, to] = units(hover.range, document);
  return {{"from", from},
          {"to", to},
          {"title", hover.title},
          {"detail", hover.detail},
          {"help", hover.help}};
}

}  // namespace tessera
