#include "scenes/formats/gltf/gltf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "base/file.h"
#include "renderer/math/elementary.h"
#include "renderer/math/transform.h"
#include "scenes/formats/gltf/gltf_instances.h"
#include "scenes/formats/gltf/gltf_mesh.h"
#include "scenes/formats/gltf/gltf_transform.h"
#include "scenes/import/decimal.h"
#include "scenes/import/picture_problem.h"
#include "scenes/import/put_vec3.h"
#include "scenes/mesh/pen.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxBytes = uint64_t{1} << 40;

constexpr std::array kNamed{"accessors", "animations", "bufferViews", "buffers", "cameras",
                            "images",    "materials",  "meshes",      "nodes",   "samplers",
                            "scenes",    "skins",      "textures"};

constexpr std::array<std::string_view, 14> kExtensions{"EXT_mesh_gpu_instancing",
                                                       "EXT_meshopt_compression",
                                                       "EXT_texture_webp",
                                                       "KHR_draco_mesh_compression",
                                                       "KHR_lights_punctual",
                                                       "KHR_materials_clearcoat",
                                                       "KHR_materials_emissive_strength",
                                                       "KHR_materials_ior",
                                                       "KHR_materials_pbrSpecularGlossiness",
                                                       "KHR_materials_transmission",
                                                       "KHR_materials_unlit",
                                                       "KHR_materials_volume",
                                                       "KHR_mesh_quantization",
                                                       "KHR_texture_transform"};

void put(const Affine& from, v1::Transform* to) {
  v1::Matrix& matrix = *to->add_steps()->mutable_matrix();
  for (const auto& row : from.m)
    for (const double value : row) matrix.add_rows(value);
}

/// Returns whether a text is a version number in [least, beyond).
bool is_version(const std::string& text, double least, double beyond) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, problem] = read_decimal(text.data(), end, number);
  return problem == std::errc() && stop == end && number >= least && number < beyond;
}

/// Whether a file shows all of its shapes, where they are, without the extension.
bool changes_look_alone(std::string_view extension) {
  constexpr std::array<std::string_view, 8> kBegins{
      "KHR_materials_", "KHR_texture_", "EXT_texture_",      "KHR_lights_",
      "EXT_lights_",    "KHR_xmp",      "EXT_mesh_features", "EXT_structural_metadata"};
  return std::any_of(kBegins.begin(), kBegins.end(),
                     [&](std::string_view begin) { return extension.starts_with(begin); });
}

/// Returns the size of a camera's angle or window. A negative one, which would mirror the picture,
/// loses its sign.
std::optional<double> size_of(const GltfValue& value, double beyond, std::string_view expected) {
  const double number = value.number(0);
  if (number > 0 && number < beyond) return number;
  const bool is_mirrored = number < 0 && -number < beyond;
  value.repair(value.shown(), expected,
               is_mirrored ? "it is taken without its sign" : "the camera is left out");
  return is_mirrored ? std::optional(-number) : std::nullopt;
}

class GltfReader {
 public:
  GltfReader(GltfFile& file, PictureCheck check)
      : file_(file),
        warnings_(file.warnings()),
        materials_(file, std::move(check), out_, warnings_),
        meshes_(file, materials_, out_, warnings_) {}

  LoadedScene read() {
    check_version();
    check_extensions();
    check_names();
    count_uses(roots());
    for (const Place& place : places_) camera_of(place);
    find_view();
    for (const Place& place : places_) node(place);
    for (const v1::Texture& texture : materials_.textures().all())
      *out_.scene.add_textures() = texture;
    if (const size_t count = file_.root()["animations"].size())
      warnings_.add("animations are not read", count);
    meshes_.list_unused_attributes();
    list_unused("meshes", "mesh", [&](size_t i) {
      const auto at = uses_.lower_bound({i});
      return at != uses_.end() && at->first.mesh == i;
    });
    list_unused("materials", "material", [&](size_t i) { return materials_.is_used(i); });
    list_unused("textures", "texture", [&](size_t i) { return materials_.is_texture_used(i); });
    list_unused("nodes", "node", [&](size_t i) { return seen_[i]; });
    if (!has_shapes_ && file_.problem()) throw *file_.problem();
    warnings_.add_to(out_, file_.name());
    return std::move(out_);
  }

 private:
  /// A mesh that is shown with the same weights is one, but each node with a skin bends its own.
  struct MeshUse {
    size_t mesh, weights = 0;
    std::optional<size_t> bent_by{};  ///< the node
    friend auto operator<=>(const MeshUse&, const MeshUse&) = default;
  };
  struct Place {
    size_t node;
    Affine world;
    std::optional<MeshUse> mesh{};
  };

  std::optional<MeshUse> mesh_of(size_t index) {
    const GltfValue node = file_.element("nodes", index), which = node["mesh"];
    const auto mesh = which.index(file_.root()["meshes"].size(), "mesh");
    if (!mesh && which.if_whole()) file_.keep_problem(which.error("no mesh", "its index"));
    if (!mesh) return std::nullopt;
    MeshUse use{*mesh, meshes_.weights(node, *mesh)};
    if (skin_of(node)) use.bent_by = index;
    return use;
  }

  std::optional<size_t> skin_of(const GltfValue& node) {
    return node["skin"].index(file_.root()["skins"].size(), "skin", "the mesh is shown unbent");
  }

  /// Null for a node that is not shown.
  const Affine* world_of(size_t node) {
    constexpr size_t kNone = std::numeric_limits<size_t>::max();
    if (place_of_.empty()) {
      place_of_.resize(node_count(), kNone);
      for (size_t i = 0; i < places_.size(); ++i) place_of_[places_[i].node] = i;
    }
    return node < place_of_.size() && place_of_[node] != kNone ? &places_[place_of_[node]].world
                                                               : nullptr;
  }

  const std::vector<Affine>& joints_of(size_t skin) {
    const auto [known, is_new] = joints_.try_emplace(skin);
    if (is_new)
      known->second = read_gltf_joints(file_, file_.element("skins", skin),
                                       [&](size_t node) { return world_of(node); });
    return known->second;
  }

  /// The shapes of a mesh; `world`, where they are to be placed, becomes none of those that a skin
  /// has taken there.
  std::vector<v1::Node> shapes_of(const MeshUse& use, Affine& world) {
    if (use.bent_by) {
      const std::vector<Affine>& joints = joints_of(*skin_of(file_.element("nodes", *use.bent_by)));
      if (!joints.empty()) {
        const GltfSkin skin{joints, world};
        world = {};
        return meshes_.read(use.mesh, use.weights, &skin, pen(world));
      }
    }
    return meshes_.read(use.mesh, use.weights, nullptr, pen(world));
  }

  /// Of a mesh that is shown several times the first place decides.
  Pen pen(const Affine& world) const { return Pen::for_view(view_, world, extent_); }

  template <typename Test>
  void list_unused(const char* array, const char* what, const Test& is_used) {
    constexpr size_t kMost = 1000;
    const GltfValue all = file_.root()[array];
    for (size_t i = 0; i < all.size() && out_.unused.size() < kMost; ++i) {
      if (is_used(i)) continue;
      const std::string name = all.at(i)["name"].text("");
      out_.unused.push_back(name.empty() ? fmt::format("{} {}", what, i)
                                         : fmt::format("{} '{}'", what, to_utf8(name)));
    }
  }

  void check_version() {
    constexpr const char* kVersion = "glTF 2.0";
    const GltfValue asset = file_.root()["asset"], version = asset["version"];
    if (!is_version(version.text(""), 2, 3)) {
      // The nodes of glTF 1.0 are no array.
      if (node_count() == 0) throw version.error(version.shown(), kVersion);
      version.repair(version.shown(), kVersion, "that is taken");
    }
    const GltfValue least = asset["minVersion"];
    if (!is_version(least.text("2.0"), 0, 2.1))
      least.repair(least.shown(), kVersion, "the file is read as that");
  }

  void check_extensions() {
    const auto is_read = [](const std::string& name) {
      return std::find(kExtensions.begin(), kExtensions.end(), name) != kExtensions.end();
    };
    const GltfValue required = file_.root()["extensionsRequired"];
    const std::vector<std::string> known(kExtensions.begin(), kExtensions.end());
    std::set<std::string> told;
    for (size_t i = 0; i < required.size(); ++i)
      if (const std::string name = required.at(i).text(""); !name.empty() && !is_read(name)) {
        const std::string found = fmt::format("the file requires extension '{}'", name);
        if (!changes_look_alone(name))
          throw required.at(i).error(found,
                                     fmt::format("one that is read{}", suggestion(name, known)));
        required.at(i).repair(found, "one that is read", "it is shown without");
        told.insert(name);
      }
    for (const std::string& name : file_.extension_names())
      if (!is_read(name) && !told.contains(name))
        warnings_.add(fmt::format("extension '{}' is not read", name));
  }

  /// Those of what is not shown too.
  void check_names() {
    for (const char* array : kNamed) {
      const GltfValue all = file_.root()[array];
      for (size_t i = 0; i < all.size(); ++i) all.at(i)["name"].text("");
    }
  }

  size_t node_count() const { return file_.root()["nodes"].size(); }

  std::vector<size_t> children(const GltfValue& list) {
    std::vector<size_t> nodes;
    for (size_t i = 0; i < list.size(); ++i)
      if (const auto index = list.at(i).index(node_count(), "node")) nodes.push_back(*index);
    return nodes;
  }

  /// Of the scene that the file shows; a file without scenes shows all nodes that are no children.
  std::vector<size_t> roots() {
    const GltfValue scenes = file_.root()["scenes"];
    const auto shown = file_.root()["scene"].index(scenes.size(), "scene");
    if (scenes.size() > 1)
      warnings_.add(fmt::format("scene {} of {} is read", shown.value_or(0), scenes.size()));
    if (scenes.size() > 0) return children(scenes.at(shown.value_or(0))["nodes"]);
    std::vector<bool> is_child(node_count());
    for (size_t i = 0; i < is_child.size(); ++i)
      for (const size_t child : children(file_.element("nodes", i)["children"]))
        is_child[child] = true;
    std::vector<size_t> out;
    for (size_t i = 0; i < is_child.size(); ++i)
      if (!is_child[i]) out.push_back(i);
    if (out.empty() && node_count() > 0) {
      file_.root()["nodes"].repair("no node without a parent", "a tree", "the first one is taken");
      out.push_back(0);
    }
    return out;
  }

  /// Lists the nodes of the graph in the order of the file's trees, each with its place in the
  /// world, and counts how often meshes are shown.
  void count_uses(const std::vector<size_t>& from) {
    seen_.resize(node_count());
    std::vector<Place> open;
    const auto push = [&](const std::vector<size_t>& nodes, const Affine& world) {
      for (size_t i = nodes.size(); i-- > 0;) open.push_back({nodes[i], world});
    };
    for (push(from, {}); !open.empty();) {
      Place place = open.back();
      open.pop_back();
      const GltfValue in = file_.element("nodes", place.node);
      if (seen_[place.node]) {
        in.repair("a node with two parents, or below itself", "a tree", "it is shown once");
        continue;
      }
      seen_[place.node] = true;
      place.world = place.world * gltf_transform(in);
      if (!is_finite(place.world)) {
        in.repair("a transform beyond all numbers", "a smaller one",
                  "the node and what is below it are left out");
        continue;
      }
      place.mesh = mesh_of(place.node);
      if (place.mesh) uses_[*place.mesh] += count_instances(place, in);
      push(children(in["children"]), place.world);
      places_.push_back(place);
    }
  }

  /// How often a node shows its mesh. One that a skin has bent has one place alone.
  size_t count_instances(const Place& place, const GltfValue& in) {
    auto frames = read_gltf_instances(file_, in);
    if (!frames) return 1;
    if (place.mesh->bent_by) {
      in.repair("instances of a mesh with a skin", "one or the other", "the mesh is shown once");
      return 1;
    }
    return instances_.emplace(place.node, std::move(*frames)).first->second.size();
  }

  void camera_of(const Place& place) {
    const GltfValue in = file_.element("nodes", place.node);
    if (const auto index = in["camera"].index(file_.root()["cameras"].size(), "camera"))
      camera(*index, in, place.world);
  }

  /// Where points and lines are seen from, which are as wide as the picture asks for: by the first
  /// camera, else by one that sees all.
  void find_view() {
    const auto& cameras = out_.scene.cameras();
    view_.set_frame_all(cameras.empty());
    if (!cameras.empty()) view_ = cameras[0];
    const bool has_strokes = std::any_of(places_.begin(), places_.end(), [&](const Place& place) {
      return place.mesh && meshes_.has_strokes(place.mesh->mesh);
    });
    if (!has_strokes || !cameras.empty()) return;
    Bounds3 all;
    for (const Place& place : places_) {
      if (!place.mesh) continue;
      const Bounds3 box = meshes_.bounds(place.mesh->mesh);
      if (box.empty()) continue;
      // Transform::bounds() would make a box of a point alone.
      const auto extend = [&](const Affine& world) {
        for (unsigned corner = 0; corner < 8; ++corner)
          all.extend(
              world(Point3{corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                           corner & 4 ? box.max.z : box.min.z}));
      };
      const auto instances = instances_.find(place.node);
      if (instances == instances_.end())
        extend(place.world);
      else
        for (const Affine& frame : instances->second) extend(place.world * frame);
    }
    extent_ = Pen::extent_of(all);
  }

  void node(const Place& place) {
    const GltfValue in = file_.element("nodes", place.node);
    const std::string name = in["name"].text("");
    const auto instances = instances_.find(place.node);
    if (instances != instances_.end())
      for (const Affine& frame : instances->second) show(*place.mesh, name, place.world * frame);
    else if (place.mesh)
      show(*place.mesh, name, place.world);
    const GltfValue light_index = in["extensions"]["KHR_lights_punctual"]["light"];
    const GltfValue lights = file_.root()["extensions"]["KHR_lights_punctual"]["lights"];
    if (const auto index = light_index.index(lights.size(), "light"))
      light(lights.at(*index), name, place.world);
  }

  void show(const MeshUse& use, const std::string& name, Affine world) {
    const auto [known, is_new] = shown_.try_emplace(use);
    const bool shared = uses_[use] > 1;
    const std::string own = file_.element("meshes", use.mesh)["name"].text("");
    if (is_new) {
      known->second.shapes = shapes_of(use, world);
      if (shared && !known->second.shapes.empty()) {
        v1::Object& object = *out_.scene.add_objects();
        object.set_name(unique_object_(own.empty() ? fmt::format("mesh {}", use.mesh) : own));
        known->second.object = object.name();
        for (v1::Node& shape : known->second.shapes) *object.add_nodes() = std::move(shape);
      }
    }
    if (known->second.shapes.empty()) return;
    has_shapes_ = true;
    v1::Node& node = *out_.scene.add_nodes();
    if (!shared && known->second.shapes.size() == 1) node = std::move(known->second.shapes.front());
    node.set_name(name.empty() ? own : name);
    if (!(world == Affine{})) put(world, node.mutable_transform());
    if (shared) {
      node.set_instance_of(known->second.object);
    } else if (known->second.shapes.size() > 1) {
      for (v1::Node& shape : known->second.shapes) *node.add_children() = std::move(shape);
    }
  }

  /// The projection of a camera; false where it shows nothing.
  static bool project(const GltfValue& in, v1::Camera& out) {
    // A wider angle would be rounded to 180 degrees.
    constexpr double kWidest = portable::kPi - 1e-15;
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    const GltfValue type = in["type"];
    const std::string name = type.text("");
    const GltfValue values = in[name.c_str()];
    if (name == "orthographic") {
      const auto x = size_of(values["xmag"], kEndless, "a number above 0");
      const auto y = size_of(values["ymag"], kEndless, "a number above 0");
      if (!x || !y) return false;
      v1::Orthographic& window = *out.mutable_orthographic();
      window.set_min_x(-*x);
      window.set_max_x(*x);
      window.set_min_y(-*y);
      window.set_max_y(*y);
    } else if (name == "perspective") {
      const auto angle = size_of(values["yfov"], kWidest, "a number above 0 and below pi");
      if (!angle) return false;
      out.mutable_perspective()->set_field_of_view(portable::degrees(*angle));
      out.mutable_perspective()->set_axis(v1::Perspective::VERTICAL);
    } else {
      type.repair(type.shown(), "perspective or orthographic", "the camera is left out");
      return false;
    }
    // These numbers do not change the picture.
    for (const char* key : {"aspectRatio", "zfar"}) values[key].above_zero();
    if (name == "perspective")
      values["znear"].above_zero();
    else
      values["znear"].amount(0);
    return true;
  }

  void camera(size_t index, const GltfValue& node, const Affine& world) {
    const GltfValue in = file_.element("cameras", index);
    v1::Camera out;
    if (!project(in, out)) return;
    if (!is_invertible(world)) {
      node.repair("a camera in a flat frame", "a frame that can be inverted",
                  "the camera is left out");
      return;
    }
    const std::string own = in["name"].text(""), node_name = node["name"].text("");
    out.set_name(unique_camera_(!own.empty()         ? own
                                : !node_name.empty() ? node_name
                                                     : fmt::format("camera {}", index)));
    put(world, out.mutable_world_from_camera());
    *out_.scene.add_cameras() = std::move(out);
  }

  /// Both angles may be the same, for a hard edge, as some programs write it. False where the light
  /// emits nothing.
  static bool aim(const GltfValue& in, v1::Light::Spot& out) {
    constexpr double kWidest = portable::kPi / 2;
    const double outer = in["outerConeAngle"].number_within(portable::kPi / 4, 0, kWidest);
    if (outer == 0) {
      in.repair("a cone of no width", "an outerConeAngle above 0", "the light is left out");
      return false;
    }
    out.set_beam_width(portable::degrees(in["innerConeAngle"].number_within(0, 0, outer)));
    out.set_cut_off(portable::degrees(outer));
    return true;
  }

  /// Candela and lux against the radiance of what is lit: a white Lambert surface sends out its
  /// irradiance over pi, while ours faces a light of intensity 1 and sends out 1.
  void light(const GltfValue& in, const std::string& node_name, const Affine& world) {
    v1::Light out;
    if (const GltfValue color = in["color"]) {
      const auto rgb = color.numbers({1, 1, 1}, 0, GltfValue::kMost);
      out.mutable_color()->set_r(rgb[0]);
      out.mutable_color()->set_g(rgb[1]);
      out.mutable_color()->set_b(rgb[2]);
    }
    out.set_intensity(in["intensity"].amount(1) / portable::kPi);
    Vec3 direction = world(Vec3{0, 0, -1});
    if (direction == Vec3{}) direction = {0, 0, -1};
    const Vec3 position = world(Point3{}) - Point3{};
    const GltfValue kind = in["type"];
    const std::string type = kind.text("");
    if (type == "directional") {
      put_vec3(normalize(direction), out.mutable_directional()->mutable_direction());
    } else if (type == "point") {
      put_vec3(position, out.mutable_point()->mutable_position());
    } else if (type == "spot") {
      v1::Light::Spot& spot = *out.mutable_spot();
      put_vec3(position, spot.mutable_position());
      put_vec3(normalize(direction), spot.mutable_direction());
      if (!aim(in["spot"], spot)) return;
    } else {
      kind.repair(kind.shown(), "directional, point or spot", "the light is left out");
      return;
    }
    if (type != "directional") {
      out.mutable_attenuation()->set_quadratic(1);
      if (const auto range = in["range"].above_zero()) out.set_radius(*range);
    }
    out.set_name(unique_light_(in["name"].text(node_name.empty() ? "light" : node_name)));
    v1::Node& node = *out_.scene.add_nodes();
    node.set_name(node_name);
    *node.mutable_light() = std::move(out);
  }

  struct Shown {
    std::vector<v1::Node> shapes;
    std::string object;
  };

  GltfFile& file_;
  LoadedScene out_;
  Warnings& warnings_;
  GltfMaterials materials_;
  GltfMeshes meshes_;
  UniqueNames unique_object_, unique_camera_, unique_light_;
  std::vector<Place> places_;
  std::vector<bool> seen_;                           ///< the nodes that places_ holds
  std::map<size_t, std::vector<Affine>> instances_;  ///< by node: their frames in its own
  std::vector<size_t> place_of_;  ///< in places_, by node; empty before the first skin
  std::map<size_t, std::vector<Affine>> joints_;  ///< by skin; empty: it cannot be read
  bool has_shapes_ = false;
  v1::Camera view_;
  double extent_ = 0;  ///< metres across all that view_ is framed for; 0 without points and lines
  std::map<MeshUse, size_t> uses_;
  std::map<MeshUse, Shown> shown_;
};

}  // namespace

LoadedScene read_gltf(const std::string& path, const ReadOptions& options) {
  const std::string bytes = read_input_file(path, kMaxBytes);
  const AssetFolder assets(path, options.assets);
  GltfFile file(bytes, path, [&](const std::string& name) {
    const auto [found, note] = assets.find_asset(name);
    if (!found)
      throw scene_error(fmt::format("'{}' is not inside {}", name, assets.shown_root(name)));
    std::string held = read_input_file(found->string(), kMaxBytes);
    if (!note.empty()) file.warnings().add(fmt::format("buffer {}", note));
    return held;
  });
  return GltfReader(file,
                    [&](const std::string& name, const std::string* held) {
                      const PictureCheck& check = options.check_picture;
                      if (!held) return picture_problem(assets, name, check);
                      return check ? check(name, held) : "";
                    })
      .read();
}

LoadedScene parse_gltf(std::string_view bytes, const std::string& name) {
  GltfFile file(bytes, name, {});
  return GltfReader(file, {}).read();
}

}  // namespace tessera
