#include "scenes/formats/include_resolver.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "scenes/import/warnings.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;

/// Fields that hold the name of a thing, or refer to one.
bool holds_name(const pb::FieldDescriptor& field) {
  static const std::set<std::string> kFields{"name", "instance_of", "materials",
                                             "back", "texture",     "normal_map"};
  return kFields.contains(field.name()) ||
         field.containing_type() == v1::Background::Cube::descriptor();
}

/// Puts `prefix` before every name, so that two files' names cannot meet.
void prefix_names(pb::Message& message, const std::string& prefix) {
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    if (field->is_map()) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    const bool name =
        field->cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING && holds_name(*field);
    for (int i = 0; i < count; ++i) {
      if (field->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
        prefix_names(field->is_repeated() ? *reflection.MutableRepeatedMessage(&message, field, i)
                                          : *reflection.MutableMessage(&message, field),
                     prefix);
      } else if (name && field->is_repeated()) {
        const std::string old = reflection.GetRepeatedString(message, field, i);
        if (!old.empty()) reflection.SetRepeatedString(&message, field, i, prefix + old);
      } else if (name) {
        const std::string old = reflection.GetString(message, field);
        if (!old.empty()) reflection.SetString(&message, field, prefix + old);
      }
    }
  }
}

template <typename Action>
void for_each_node(v1::Node& node, const Action& action) {
  action(node);
  for (v1::Node& child : *node.mutable_children()) for_each_node(child, action);
  if (node.shape().has_csg())
    for (v1::Node& operand : *node.mutable_shape()->mutable_csg()->mutable_operands())
      for_each_node(operand, action);
}

template <typename Action>
void for_each_node(v1::Scene& scene, const Action& action) {
  for (v1::Node& node : *scene.mutable_nodes()) for_each_node(node, action);
  for (v1::Object& object : *scene.mutable_objects())
    for (v1::Node& node : *object.mutable_nodes()) for_each_node(node, action);
}

void set_material(v1::Scene& scene, const std::string& name) {
  scene.clear_materials();
  for_each_node(scene, [&](v1::Node& node) {
    if (!node.has_shape()) return;
    v1::Shape& shape = *node.mutable_shape();
    if (shape.materials_size() == 0) shape.add_materials();
    for (std::string& material : *shape.mutable_materials()) material = name;
  });
}

bool has_lights(v1::Scene& scene) {
  bool found = false;
  for_each_node(scene, [&](v1::Node& node) { found |= node.has_light(); });
  return found;
}

void place_camera(v1::Camera& camera, const v1::Transform& placement) {
  const auto before = [&](v1::Transform& transform) {
    v1::Transform whole = placement;
    whole.MergeFrom(transform);
    transform = std::move(whole);
  };
  before(*camera.mutable_world_from_camera());
  for (v1::TransformKey& key : *camera.mutable_keys()) before(*key.mutable_transform());
}

/// The node that the file goes into.
v1::Node& add_place(v1::Scene& scene, const v1::Include& include) {
  if (include.object().empty()) {
    v1::Node& node = *scene.add_nodes();
    *node.mutable_transform() = include.transform();
    return node;
  }
  v1::Object& object = *scene.add_objects();
  object.set_name(include.object());
  return *object.add_nodes();
}

template <typename Things>
void move_all(Things& from, Things& to) {
  for (auto& thing : from) *to.Add() = std::move(thing);
  from.Clear();
}

}  // namespace

AssetFolder::Found included_file(const AssetFolder& assets, const fs::path& file,
                                 const v1::Include& include) {
  const AssetFolder from = assets.from(file.parent_path());
  AssetFolder::Found found = from.find_asset(include.file());
  if (!found.file)
    throw scene_error({file.string()},
                      fmt::format("includes '{}', which is not inside {}", include.file(),
                                  from.shown_root(include.file())),
                      "a file in that folder or below it");
  return found;
}

void IncludeResolver::put(LoadedScene& into, const v1::Include& include, const Part& made,
                          const fs::path& file) {
  v1::Node& node = add_place(into.scene, include);
  node.set_name(to_utf8(file.stem().string()));
  node.set_instance_of(made.object);
  if (const uint32_t origin = origin_of(include)) set_origin(node, origin);
  for (const v1::Node& child : made.nodes) *node.add_children() = child;
  for (const v1::Camera& camera : made.cameras) {
    v1::Camera& placed = *into.scene.add_cameras();
    placed = camera;
    place_camera(placed, include.transform());
  }
}

IncludeResolver::IncludeResolver(const std::string& file, const std::string& assets, Reader reader)
    : first_(whole_path(file)), assets_(file, assets), reader_(std::move(reader)) {}

void IncludeResolver::resolve(LoadedScene& loaded) { resolve(loaded, first_); }

std::string IncludeResolver::unique_prefix(const fs::path& file) {
  const std::string stem = to_utf8(file.stem().string());
  const int count = ++prefixes_[stem];
  return count == 1 ? stem + "/" : fmt::format("{}#{}/", stem, count);
}

const IncludeResolver::Part& IncludeResolver::part(LoadedScene& into, const v1::Include& include,
                                                   const fs::path& file, const Reader& read) {
  const std::string key = fmt::format("{}\n{}\n{}\n{}", file.string(), include.format(),
                                      include.material(), include.geometry_only());
  const auto known = parts_.find(key);
  if (known != parts_.end()) return known->second;
  return parts_.emplace(key, absorb(into, include, read(file.string(), include.format()), file))
      .first->second;
}

IncludeResolver::Part IncludeResolver::absorb(LoadedScene& into, const v1::Include& include,
                                              LoadedScene loaded, const fs::path& file) {
  const std::string prefix = unique_prefix(file);
  v1::Scene& scene = loaded.scene;
  scene.clear_metadata();
  into.origins.absorb(scene, loaded.origins);
  prefix_names(scene, prefix);
  if (!include.material().empty()) set_material(scene, include.material());
  if (include.geometry_only()) {
    scene.clear_cameras();
    scene.clear_background();
    scene.clear_fog();
    for_each_node(scene, [](v1::Node& node) { node.clear_light(); });
  }

  Part made;
  for (v1::Camera& camera : *scene.mutable_cameras()) made.cameras.push_back(std::move(camera));
  if (has_lights(scene)) {
    for (v1::Node& node : *scene.mutable_nodes()) made.nodes.push_back(std::move(node));
  } else {
    made.object = prefix;
    v1::Object& object = *into.scene.add_objects();
    object.set_name(made.object);
    move_all(*scene.mutable_nodes(), *object.mutable_nodes());
  }
  move_all(*scene.mutable_objects(), *into.scene.mutable_objects());
  move_all(*scene.mutable_materials(), *into.scene.mutable_materials());
  move_all(*scene.mutable_textures(), *into.scene.mutable_textures());
  if (!into.scene.has_background() && scene.has_background())
    *into.scene.mutable_background() = std::move(*scene.mutable_background());
  if (!into.scene.has_fog() && scene.has_fog())
    *into.scene.mutable_fog() = std::move(*scene.mutable_fog());
  for (const auto& [digest, data] : loaded.blobs.all()) into.blobs.put(digest, data);
  std::move(loaded.warnings.begin(), loaded.warnings.end(), std::back_inserter(into.warnings));
  std::move(loaded.warning_diagnostics.begin(), loaded.warning_diagnostics.end(),
            std::back_inserter(into.warning_diagnostics));
  std::move(loaded.repairs.begin(), loaded.repairs.end(), std::back_inserter(into.repairs));
  std::move(loaded.unused.begin(), loaded.unused.end(), std::back_inserter(into.unused));
  into.depends_on_frame |= loaded.depends_on_frame;
  return made;
}

void IncludeResolver::place(LoadedScene& into, const v1::Include& include,
                            const Reader& read_whole) {
  std::error_code ignored;
  const fs::path file = fs::weakly_canonical(include.file(), ignored);
  put(into, include,
      part(into, include, file.empty() ? fs::path(include.file()) : file, read_whole), file);
}

void IncludeResolver::resolve(LoadedScene& loaded, const fs::path& file) {
  if (loaded.scene.includes_size() == 0) return;
  if (open_.size() >= static_cast<size_t>(kMaxDepth))
    throw scene_error({file.string()}, "files included too deep",
                      fmt::format("at most {} levels", kMaxDepth));
  open_.push_back(file);
  const auto includes = std::move(*loaded.scene.mutable_includes());
  loaded.scene.clear_includes();
  for (const v1::Include& include : includes) {
    const auto [found, note] = included_file(assets_, file, include);
    const fs::path target = *found;
    if (!note.empty()) add_warning(loaded, file.string(), "the included file " + note);
    if (std::find(open_.begin(), open_.end(), target) != open_.end())
      throw scene_error({file.string()},
                        fmt::format("includes '{}', which includes it in turn", include.file()),
                        "files that do not include themselves");
    if (++placements_ > kMaxPlacements)
      throw scene_error({file.string()}, "too many includes",
                        fmt::format("at most {}", kMaxPlacements));
    const Part& made = part(loaded, include, target, [&](const auto& path, const auto& format) {
      LoadedScene read = reader_(path, format);
      resolve(read, path);
      return read;
    });
    put(loaded, include, made, target);
  }
  open_.pop_back();
}

}  // namespace tessera
