#include "studio/new_scene.h"

#include <spdlog/spdlog.h>

#include <filesystem>

#include "base/error.h"
#include "base/lower_case.h"
#include "scenes/edit/edit.h"

namespace tessera {
namespace {

constexpr const char* kModelScene = R"(metadata { title: "Untitled" }
settings {
    width: 960
    height: 540
}
cameras {
    name: "camera"
    world_from_camera {
        steps { look_at { eye { x: 3 y: 2 z: 5 } target { x: 0 y: 0 z: 0 } } }
    }
    perspective { field_of_view: 40 axis: VERTICAL }
    headlight { directional { direction { x: 0 y: 0 z: -1 } } }
    frame_all: true
}
background { solid { r: 0.2 g: 0.2 b: 0.2 } }
)";

}  // namespace

std::vector<TemplateFile> scene_of_model(const std::string& model) {
  const edit::Outline outline = edit::outline(edit::Language::tessera, kModelScene);
  const edit::Change change = edit::add_include(outline, model);
  return {{"untitled.tessera", edit::apply_edits(outline.text(), change.edits)}};
}

bool is_bare_model(std::string_view file) {
  const std::string name = lower_case(std::string(file));
  return name.ends_with(".obj") || name.ends_with(".ply") || name.ends_with(".stl") ||
         name.ends_with(".glb");
}

std::string scene_to_open(const Folder& folder, const std::string& file) {
  if (!is_bare_model(file) || folder.is_read_only()) return file;
  const TemplateFile scene = scene_of_model(file).front();
  const std::filesystem::path path(scene.name);
  for (const FileEntry& entry : folder.list().entries) {
    if (entry.size == scene.text.size() && entry.name.starts_with(path.stem().string()) &&
        folder.read(entry.name, scene.text.size()).bytes == scene.text)
      return entry.name;
  }
  try {
    const std::string free = folder.free_name(scene.name);
    folder.create(free, scene.text);
    return free;
  } catch (const Error& error) {
    spdlog::warn("no scene is made that places {}: {}", file, error.what());
    return file;
  }
}

std::vector<TemplateFile> scene_of_template(const std::string& id) {
  for (const SceneTemplate& each : scene_templates()) {
    if (each.id == id) return each.files;
  }
  return {};
}

}  // namespace tessera
