#include <fmt/format.h>

#include <cmath>

#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/crt_edit.h"
#include "scenes/edit/crt_literals.h"
#include "scenes/edit/crt_outline.h"
#include "scenes/edit/crt_words.h"
#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/language_placement.h"
#include "scenes/edit/layout.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"

namespace tessera::edit {

namespace {

std::string free_variable(std::string_view wish, const Outline& outline) {
  std::vector<std::string> names;
  for (const auto& [name, variable] : crt_variables(outline.text(), outline.tree()))
    names.emplace_back(name);
  return free_name(wish, names, "");
}

int settings_of(const Outline& outline) {
  for (size_t i = 0; i < outline.entities().size(); ++i)
    if (outline.entities()[i].kind == EntityKind::settings) return static_cast<int>(i);
  return -1;
}

/// Gives a script without cameras one that has no attributes yet: a variable before the Settings,
/// of the name that these have for it already, or else of one that they get.
void add_camera(EditSequence& sequence) {
  sequence.then([](const Outline& now) {
    const int settings = settings_of(now);
    if (settings < 0) return refuse("a script without Settings", "Settings { ... } for its camera");
    const Entity& holder = now.entities()[static_cast<size_t>(settings)];
    std::string name = free_variable("cam", now);
    if (const Field* const written = written_field(holder, "camera")) {
      const CrtVariables variables = crt_variables(now.text(), now.tree());
      const auto named = variables.find(written->text);
      if (named == variables.end() || named->second.assigned > 0)
        return refuse(written->text, "the name of a Camera, or no camera at all", written->value);
      name = written->text;
    }
    Change change;
    change.edits.push_back(
        Layout(now.text(), "--").before(holder.range, fmt::format("{} = Camera {{ }}", name)));
    return change;
  });
  sequence.then([](const Outline& now) {
    const int settings = settings_of(now), camera = find_camera(now, "").value_or(0);
    if (settings < 0 || written_field(now.entities()[static_cast<size_t>(settings)], "camera"))
      return Change();
    return set_crt_field(now, settings, "camera", now.entities()[static_cast<size_t>(camera)].name);
  });
}

}  // namespace

std::vector<EntityTemplate> crt_templates() {
  return {{"file", "Mesh", {{"file", ""}}},
          {"sphere", "Sphere", {{"center", "0 0 0"}, {"radius", "1"}}},
          {"box", "Box", {{"cornerA", "-1 -1 -1"}, {"cornerB", "1 1 1"}}},
          {"plane", "Plane", {{"normal", "0 1 0"}, {"position", "0 0 0"}}},
          {"disc", "Disc", {{"center", "0 0 0"}, {"radius", "1"}}},
          {"cylinder", "Cylinder", {{"base", "0 -1 0"}, {"top", "0 1 0"}, {"radius", "1"}}},
          {"cone", "Cone", {{"base", "0 -1 0"}, {"top", "0 1 0"}, {"radius", "1"}}},
          {"torus", "Torus", {{"center", "0 0 0"}, {"radius", "1"}, {"thickness", ".25"}}},
          {"point light", "PointLight", {{"origin", "2 4 -3"}, {"color", "1 1 1"}}},
          {"parallel light",
           "ParallelLight",
           {{"from", "1 2 -1"}, {"pointing", "0 0 0"}, {"color", "1 1 1"}}},
          {"material", "Material", {{"color", ".8 .8 .8"}}}};
}

Change add_crt(const Outline& outline, const EntityTemplate& made) {
  const CrtObjectWord* word = find_crt_word(made.type);
  if (!word) return refuse(made.type, "an object of the language");
  if (made.position && word->kind != EntityKind::shape && word->kind != EntityKind::include)
    return refuse(fmt::format("a place for {}", made.name), "one for a shape or a file");
  std::string text, material;
  for (const auto& [name, value] : made.fields) {
    const CrtAttributeWord* attribute = find_crt_attribute(word, name);
    if (!attribute) return refuse(name, fmt::format("an attribute of {}", made.type));
    const Field field = describe(*attribute);
    if (auto refusal = check_new_crt(outline, field, value))
      return refuse(refusal->found, refusal->expected);
    text += fmt::format("{} -> {} ", name, new_crt_literal(field, value));
    if (name == "material") material = value;
  }
  const Entity* scene = nullptr;
  const int at_settings = settings_of(outline);
  const Entity* const settings =
      at_settings < 0 ? nullptr : &outline.entities()[static_cast<size_t>(at_settings)];
  const Entity* last_material = nullptr;
  for (const Entity& entity : outline.entities()) {
    if (entity.type == "Scene") scene = &entity;
    if (entity.kind == EntityKind::material && !entity.name.empty() && entity.parent == 0)
      last_material = &entity;
  }
  const Layout layout = Layout(outline.text(), "--");
  Change change;
  if (word->kind == EntityKind::material) {
    const std::string line =
        fmt::format("{} = Material {{ {}}}", free_variable("material", outline), text);
    change.edits.push_back(last_material ? layout.behind(last_material->range, line)
                           : settings    ? layout.before(settings->range, line)
                                         : layout.at_end(line));
    return change;
  }
  const bool is_light = word->kind == EntityKind::light;
  const bool needs_material = word->kind == EntityKind::shape && material.empty();
  if (needs_material)
    text +=
        fmt::format("material -> {} ", last_material ? last_material->name
                                                     : "Material { color -> rgb(0.8, 0.8, 0.8) }");
  std::string line = fmt::format("{} {{ {}}}", made.type, text);
  if (made.position)
    line +=
        fmt::format(" <translate vec3({})>", fmt::join(typed_parts(written_position(made)), ", "));
  if (is_light) line = "lights -> " + line;
  const Entity* holder = is_light ? settings : scene;
  if (!holder)
    return refuse(fmt::format("a script without {}", is_light ? "Settings" : "Scene"),
                  "one to add it to");
  const int32_t last = outline.tree()[static_cast<int32_t>(holder->syntax)].last_child;
  change.edits.push_back(last >= 0 ? layout.behind(outline.tree()[last].range, line)
                                   : layout.inside(holder->body, holder->range.begin, line,
                                                   indentation_unit(outline.text(), "    ")));
  return change;
}

Change write_crt_camera(const Outline& outline, std::string_view name, const CameraPose& pose) {
  if (pose.orthographic) return refuse("an orthographic camera", "a projection that CRT has");
  EditSequence sequence(outline);
  int camera = find_camera(outline, name).value_or(-1);
  if (camera < 0) {
    if (find_camera(outline, ""))
      return refuse(fmt::format("no Camera '{}'", name), "a camera's name");
    add_camera(sequence);
    camera = find_camera(sequence.now(), "").value_or(-1);
    if (camera < 0) return sequence.finish();
  }
  sequence.keep(camera);
  const Entity asked = sequence.now().entities()[static_cast<size_t>(camera)];
  const std::string projection = written_text(asked, "projection", "pinhole");
  const bool is_panorama = projection != "pinhole";
  if (!is_panorama && !pose.axis.empty() && pose.axis != "vertical")
    return refuse(fmt::format("a field of view over the {} axis", pose.axis),
                  "the vertical one, as CRT has it");
  // What is missing is no number: all three have to be there.
  WrittenCamera there{{NAN, NAN, NAN}, {NAN, NAN, NAN}};
  std::optional<double> angle;
  for (const Field& field : asked.fields) {
    const auto triple = read_triple(field.text);
    if (field.name == "position") there.eye = triple.value_or(Triple{NAN, NAN, NAN});
    if (field.name == "pointing") there.target = triple.value_or(Triple{NAN, NAN, NAN});
    if (field.name == "fov") angle = typed_number(field.text);
  }
  const CameraNumbers numbers = camera_numbers(pose, there, false);
  const auto set = [&](std::string_view field, const std::string& value) {
    sequence.then([&](const Outline& now) { return set_crt_field(now, camera, field, value); });
  };
  if (numbers.eye) set("position", *numbers.eye);
  if (numbers.target) set("pointing", *numbers.target);
  constexpr double kSame = 1e-6;
  if (!is_panorama && pose.field_of_view &&
      (!angle || std::abs(*angle - *pose.field_of_view) > kSame))
    set("fov", shortest_number(*pose.field_of_view, kSame));
  return sequence.finish();
}

}  // namespace tessera::edit
