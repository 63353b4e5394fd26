#include "scenes/edit/edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/crt_edit.h"
#include "scenes/edit/gltf_edit.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/statement_edit.h"
#include "scenes/edit/x3d_edit.h"

namespace tessera::edit {
namespace {

bool is_message(Language language) {
  return language == Language::tessera || language == Language::json;
}

bool is_x3d(Language language) {
  return language == Language::x3d || language == Language::classic_x3d;
}

bool is_statements(Language language) {
  return language == Language::obj || language == Language::mtl;
}

Change not_edited(const Outline&) {
  return refuse("a language that is not edited in this way", "typing in the text");
}

std::optional<Change> refuse_entity(const Outline& outline, int entity) {
  if (entity >= 0 && static_cast<size_t>(entity) < outline.entities().size()) return {};
  return refuse(fmt::format("entity {}", entity), "an entity of this version of the text");
}

}  // namespace

Change set_field(const Outline& outline, int entity, std::string_view field,
                 std::string_view value) {
  if (auto refusal = refuse_entity(outline, entity)) return *refusal;
  if (is_message(outline.language())) return set_message_field(outline, entity, field, value);
  if (outline.language() == Language::crt) return set_crt_field(outline, entity, field, value);
  if (outline.language() == Language::gltf) return set_gltf_field(outline, entity, field, value);
  if (is_x3d(outline.language())) return set_xml_field(outline, entity, field, value);
  if (is_statements(outline.language())) return set_statement(outline, entity, field, value);
  return not_edited(outline);
}

Change reset_field(const Outline& outline, int entity, std::string_view field) {
  if (auto refusal = refuse_entity(outline, entity)) return *refusal;
  if (is_message(outline.language())) return reset_message_field(outline, entity, field);
  if (outline.language() == Language::crt) return reset_crt_field(outline, entity, field);
  if (is_x3d(outline.language())) return reset_xml_field(outline, entity, field);
  if (is_statements(outline.language())) return reset_statement(outline, entity, field);
  return not_edited(outline);
}

Change remove(const Outline& outline, int entity) {
  if (auto refusal = refuse_entity(outline, entity)) return *refusal;
  if (is_message(outline.language())) return remove_message(outline, entity);
  if (outline.language() == Language::crt) return remove_crt(outline, entity);
  if (is_x3d(outline.language())) return remove_xml(outline, entity);
  if (is_statements(outline.language())) return remove_statements(outline, entity);
  return not_edited(outline);
}

Change duplicate(const Outline& outline, int entity) {
  if (auto refusal = refuse_entity(outline, entity)) return *refusal;
  if (is_message(outline.language())) return duplicate_message(outline, entity);
  if (outline.language() == Language::crt) return duplicate_crt(outline, entity);
  if (is_x3d(outline.language())) return duplicate_xml(outline, entity);
  if (is_statements(outline.language())) return duplicate_statements(outline, entity);
  return not_edited(outline);
}

std::vector<EntityTemplate> entity_templates(Language language) {
  if (is_message(language)) return message_templates();
  if (language == Language::crt) return crt_templates();
  if (is_x3d(language)) return xml_templates();
  return {};
}

Change add(const Outline& outline, int parent, const EntityTemplate& made) {
  if (auto refusal = refuse_entity(outline, parent)) return *refusal;
  if (is_message(outline.language())) return add_message(outline, parent, made);
  if (outline.language() == Language::crt) return add_crt(outline, made);
  if (is_x3d(outline.language())) return add_xml(outline, made);
  return not_edited(outline);
}

std::string written_position(const EntityTemplate& made) {
  constexpr double kPrecision = 1e-3;
  double largest = 0;
  for (const double each : *made.position) largest = std::max(largest, std::abs(each));
  std::string text;
  for (const double each : *made.position)
    text += (text.empty() ? "" : " ") + shortest_number(each, largest * kPrecision);
  return text;
}

Change add_include(const Outline& outline, std::string_view file,
                   const std::optional<std::array<double, 3>>& position) {
  const std::string name(file);
  if (is_message(outline.language()))
    return add_message(outline, 0, {"file", "includes", {{"file", name}}, position});
  if (outline.language() == Language::crt)
    return add_crt(outline, {"file", "Mesh", {{"file", name}}, position});
  if (is_x3d(outline.language()))
    return add_xml(outline, {"file", "Inline", {{"url", name}}, position});
  return not_edited(outline);
}

Change set_panorama(const Outline& outline, std::string_view file) {
  if (is_message(outline.language())) return set_message_panorama(outline, file);
  return refuse("a language without panoramas", ".tessera or .json");
}

Change write_camera(const Outline& outline, std::string_view name, const CameraPose& pose) {
  if (auto refusal = check_pose(pose)) {
    Change change;
    change.refusal = std::move(refusal);
    return change;
  }
  if (is_message(outline.language())) return write_message_camera(outline, name, pose);
  if (outline.language() == Language::crt) return write_crt_camera(outline, name, pose);
  if (outline.language() == Language::gltf) return write_gltf_camera(outline, name, pose);
  if (is_x3d(outline.language())) return write_xml_camera(outline, name, pose);
  if (is_statements(outline.language()))
    return refuse("a model, which has no cameras", "a scene that places it");
  return not_edited(outline);
}

}  // namespace tessera::edit
