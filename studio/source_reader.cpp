#include "studio/source_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/error.h"
#include "scenes/edit/vocabulary.h"
#include "studio/page_answer.h"
#include "studio/source_settings.h"

namespace tessera {
namespace {

using Json = nlohmann::json;
using What = page::Source::What;

edit::Change refuse(std::string found, std::string expected) {
  edit::Change change;
  change.refusal = edit::Refusal{std::move(found), std::move(expected), {}};
  return change;
}

/// The field of an entity that says which file it is.
std::string file_field(const edit::EntityTemplate& made) {
  for (const auto& [name, value] : made.fields) {
    if (name == "file" || name == "url" || name.ends_with(".file")) return name;
  }
  return "";
}

edit::Change add(const edit::Outline& outline, int parent, const page::Source& request) {
  if (request.kind == "include") return edit::add_include(outline, request.text, request.position);
  if (request.kind == "panorama") return edit::set_panorama(outline, request.text);
  for (edit::EntityTemplate& made : edit::entity_templates(outline.language())) {
    if (made.name != request.kind) continue;
    const std::string file = file_field(made);
    for (auto& [name, value] : made.fields) {
      if (name == file && !file.empty()) value = request.text;
    }
    made.position = request.position;
    return edit::add(outline, parent, made);
  }
  return refuse(request.kind, "the name of a template");
}

edit::Change write_camera(const edit::Outline& outline, const page::Source& request) {
  if (!request.camera) return refuse("no camera", "eye, target and up");
  const FreeCamera& camera = *request.camera;
  edit::CameraPose pose{.eye = camera.eye,
                        .target = camera.target,
                        .up = camera.up,
                        .field_of_view = {},
                        .axis = camera.axis,
                        .orthographic = camera.orthographic,
                        .aspect = request.aspect};
  if (!camera.orthographic) pose.field_of_view = camera.fov;
  return edit::write_camera(outline, request.text, pose);
}

edit::Change change_of(const edit::Outline& outline, int entity, const page::Source& request) {
  switch (request.what) {
    case What::set:
      return edit::set_field(outline, entity, request.field, request.text);
    case What::reset:
      return edit::reset_field(outline, entity, request.field);
    case What::add:
      return add(outline, std::max(entity, 0), request);
    case What::remove:
      return edit::remove(outline, entity);
    case What::duplicate:
      return edit::duplicate(outline, entity);
    case What::write_camera:
      return write_camera(outline, request);
    case What::place:
      if (!request.placement) return refuse("no placement", "one");
      return entity < 0 ? edit::add_placement(outline, *request.placement)
                        : edit::set_placement(outline, entity, *request.placement);
    default:
      return write_settings(outline, request.options);
  }
}

/// The reason of a change, as the history of a page shows it.
std::string reason(const page::Source& request) {
  switch (request.what) {
    case What::set:
    case What::reset:
      return fmt::format("property {}", request.field);
    case What::add:
      return fmt::format("add {}", request.kind);
    case What::place:
      return fmt::format("model {}", request.placement->file);
    case What::write_camera:
      return "camera";
    case What::write_settings:
      return "settings";
    default:
      return page::name_of(request.what);
  }
}

}  // namespace

const SourceReader::Read* SourceReader::read(const std::string& file, const Document& document) {
  const auto language = edit::language_of(file);
  if (!language) return nullptr;
  std::string text = document.text();
  const auto at = std::find_if(kept_.begin(), kept_.end(), [&](const Read& each) {
    // A file that was opened anew counts its versions from 1 again.
    return each.file == file && each.version == document.version() && each.text == text;
  });
  if (at != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, at);
    return &kept_.front();
  }
  std::erase_if(kept_, [&](const Read& each) { return each.file == file; });
  edit::Outline made = edit::outline(*language, text);
  EntityIds ids(made);
  kept_.push_front({file, document.version(), std::move(text), std::move(made), std::move(ids)});
  if (kept_.size() > kMostKept) kept_.pop_back();
  return &kept_.front();
}

FileOutline SourceReader::outline(const OutlineOrder& order) {
  FileOutline made{order.file, order.ticket, order.document.version(), ""};
  const Read* const text = read(order.file, order.document);
  if (!text) return made;
  Json fields = outline_json(text->outline, text->ids);
  fields["file"] = order.file;
  fields["version"] = made.version;
  made.message = page_answer(0, "outline", std::move(fields)).text;
  return made;
}

SendText SourceReader::answer(const SourceOrder& order) {
  const page::Source& request = order.request;
  const auto answer = [&](std::string_view kind, Json fields) {
    fields["file"] = request.file;
    if (request.number != 0) fields["number"] = request.number;
    return page_answer(order.client, kind, std::move(fields));
  };
  const auto refused = [&](const std::string& found, const std::string& expected) {
    Json fields{{"request", page::name_of(request.what)},
                {"why", fmt::format("found {}; expected {}", found, expected)},
                {"found", found},
                {"expected", expected}};
    if (!request.entity.empty()) fields["entity"] = request.entity;
    if (!request.field.empty()) fields["field"] = request.field;
    return answer("refused", std::move(fields));
  };
  const Read* const text = read(request.file, order.document);
  if (!text) return refused("a file of another kind", ".tessera, .json, .crt or .x3d");
  const uint64_t version = order.document.version();
  const edit::Outline& outline = text->outline;
  const size_t byte = order.document.text_byte_of(request.offset);
  if (request.what == What::complete) {
    Json fields = completions_json(edit::completions(outline, byte), order.document);
    fields["version"] = version;
    return answer("completions", std::move(fields));
  }
  if (request.what == What::hover) {
    const auto hover = edit::hover(outline, byte);
    return answer("hovered", hover ? hover_json(*hover, order.document) : Json::object());
  }
  const int entity = request.entity.empty() ? -1 : text->ids.find(request.entity);
  if (entity < 0 && !request.entity.empty())
    return refused(request.entity, "an entity of this version of the text");
  if (request.what == What::placement)
    return answer("placement",
                  placement_json(edit::read_placement(outline, std::max(entity, 0)), outline));
  if (request.what == What::fields) {
    Json list = Json::array();
    for (const edit::Field& field : edit::all_fields(outline, std::max(entity, 0)))
      list.push_back(field_json(field, order.document));
    return answer("fields",
                  {{"version", version}, {"entity", request.entity}, {"fields", std::move(list)}});
  }
  if (request.what == What::camera_text) {
    const edit::Change change = write_camera(outline, request);
    if (change.refusal) return refused(change.refusal->found, change.refusal->expected);
    const edit::Outline made =
        edit::outline(outline.language(), edit::apply_edits(outline.text(), change.edits));
    const edit::Entity& camera = made.entities()[static_cast<size_t>(change.entity)];
    return answer("camera_text", {{"text", edit::text_of(made.text(), camera.range)}});
  }
  const edit::Change change = change_of(outline, entity, request);
  if (change.refusal) return refused(change.refusal->found, change.refusal->expected);
  return answer("change", {{"base", version},
                           {"changes", changes_json(change.edits, order.document)},
                           {"why", reason(request)},
                           {"changed", change.changed}});
}

}  // namespace tessera
