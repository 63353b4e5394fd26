#include "scenes/formats/gltf/gltf_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "base/file.h"
#include "base/plural.h"
#include "scenes/formats/gltf/gltf_draco.h"
#include "scenes/mesh/mesh_data.h"
#include "scenes/mesh/vertex_colors.h"

namespace tessera {
namespace {

constexpr std::string_view kPrimitive = "the primitive is left out";
constexpr uint64_t kNumbersOfStroke = 512;  // of memory for a point or a line's end, at most

enum Mode : uint64_t { kPoints, kLines, kLineLoop, kLineStrip, kTriangles, kStrip, kFan };

/// Corners of a part of a primitive: 1 of a point, 2 of a line, 3 of a triangle.
size_t corners_each(uint64_t mode) { return mode == kPoints ? 1 : mode < kTriangles ? 2 : 3; }

/// Calls action with the corners of each part, triangles and lines without extent too.
template <typename Action>
void for_each_part(uint64_t mode, const std::vector<uint32_t>& corners, const Action& action) {
  using Part = std::initializer_list<uint32_t>;
  const size_t n = corners.size(), each = corners_each(mode);
  const size_t step = mode == kLines || mode == kTriangles ? each : 1;
  for (size_t i = 0; i + each <= n; i += step) {
    if (each == 1)
      action(Part{corners[i]});
    else if (each == 2)
      action(Part{corners[i], corners[i + 1]});
    else if (mode == kFan)
      action(Part{corners[i + 1], corners[i + 2], corners[0]});
    else if (mode == kTriangles || i % 2 == 0)
      action(Part{corners[i], corners[i + 1], corners[i + 2]});
    else
      action(Part{corners[i + 1], corners[i], corners[i + 2]});
  }
  if (mode == kLineLoop && n > 2) action(Part{corners[n - 1], corners[0]});
}

/// Limits the components of colours to 0 to 1 and warns of the first one that is outside by more
/// than rounding.
void limit_colors(const GltfValue& reference, std::vector<float>& colors) {
  constexpr float kRounding = 1e-6F;
  std::optional<float> odd;
  for (float& part : colors) {
    const float nearest = std::clamp(part, 0.F, 1.F);
    if (!odd && std::abs(part - nearest) > kRounding) odd = part;
    part = nearest;
  }
  if (odd)
    reference.repair(fmt::format("a component of {}", *odd), "0 to 1", "the nearest one is taken");
}

/// Sets tangents to 0 that lie along their normals; how many say nothing, those that were 0 too.
size_t clear_useless_tangents(const std::vector<float>& normals, std::vector<float>& tangents) {
  constexpr double kLeastSine = 1e-6;
  size_t useless = 0;
  for (size_t vertex = 0; vertex < normals.size() / 3; ++vertex) {
    const Vec3 normal = vec_at(normals, 3 * vertex), tangent = vec_at(tangents, 4 * vertex);
    const double sine_bound = kLeastSine * length(normal) * length(tangent);
    if (length(cross(normal, tangent)) > sine_bound) continue;
    put_vec({}, tangents, 4 * vertex);
    ++useless;
  }
  return useless;
}

}  // namespace

/// The primitives of one shape.
struct GltfMeshes::Group {
  explicit Group(Attributes from) : attributes(std::move(from)) {}

  Attributes attributes;
  size_t vertex_count = 0;
  size_t corners_each = 3;  ///< as for_each_part gives them
  std::vector<std::string> materials;
  std::vector<uint32_t> corners, face_materials;
  uint32_t first = 0, last = 0;  ///< the vertices that are used: [first, last)
};

std::string GltfMeshes::Attributes::key() const {
  std::string key;
  for (const GltfValue* value : {&position, &normal, &uv, &second_uv, &color, &tangent}) {
    const auto index = value->whole();
    key += index ? fmt::format("{} ", *index) : "- ";
  }
  for (const auto& [target, weight] : targets)
    for (const char* attribute : {"POSITION", "NORMAL", "TANGENT"}) {
      const auto index = target[attribute].whole();
      key += index ? fmt::format("{} ", *index) : "- ";
    }
  for (const auto& [joints, shares] : influences)
    key += fmt::format("{} {} ", joints.shown(), shares.shown());
  return key;
}

GltfMeshes::Attributes GltfMeshes::attributes_of(const GltfValue& primitive,
                                                 const GltfMaterialUse& material,
                                                 const Weights& weights, bool is_bent) {
  const GltfValue in = primitive["attributes"];
  const auto use = [&](const std::string& name) {
    attributes_[name] = true;
    return in[name.c_str()];
  };
  const GltfUvSets& sets = materials_.uv_sets(material);
  const auto uv_set = [&](size_t which) {
    const std::string name = fmt::format("TEXCOORD_{}", sets.size() > which ? sets[which] : 0);
    if (in[name.c_str()] || !in["TEXCOORD_0"]) return name;
    in.repair("no " + name, "the texture coordinates that its material uses",
              "TEXCOORD_0 is taken");
    return std::string("TEXCOORD_0");
  };
  Attributes out{use("POSITION"),
                 use("NORMAL"),
                 use(uv_set(0)),
                 sets.size() > 1 ? use(uv_set(1)) : GltfValue{nullptr, nullptr, ""},
                 use("COLOR_0"),
                 use("TANGENT"),
                 {},
                 {}};
  for (size_t set = 0; is_bent; ++set) {
    const std::string joints = fmt::format("JOINTS_{}", set),
                      shares = fmt::format("WEIGHTS_{}", set);
    if (!in[joints.c_str()] || !in[shares.c_str()]) break;
    out.influences.emplace_back(use(joints), use(shares));
  }
  if (is_bent && out.influences.empty())
    in.repair("no joints", "JOINTS_0 and WEIGHTS_0, as its node has a skin", "it is shown unbent");
  for (const std::string& name : in.keys()) attributes_.try_emplace(name, false);
  const GltfValue targets = primitive["targets"];
  if (!weights.empty() && targets.size() != weights.size())
    primitive.repair(fmt::format("{} morph targets", targets.size()),
                     fmt::format("{}, one a weight", weights.size()), "the others have no weight");
  for (size_t i = 0; i < std::min(weights.size(), targets.size()); ++i)
    if (weights[i] != 0) out.targets.emplace_back(targets.at(i), weights[i]);
  return out;
}

bool GltfMeshes::unpack(const GltfValue& primitive) {
  const GltfValue packed = primitive["extensions"]["KHR_draco_mesh_compression"];
  if (!packed) return true;
  const auto position =
      primitive["attributes"]["POSITION"].index(file_.root()["accessors"].size(), "accessor");
  const bool has_own = position && file_.element("accessors", *position)["bufferView"];
  const auto [known, is_new] = unpacked_.try_emplace(primitive.path(), false);
  if (is_new)
    known->second = file_.attempt(has_own ? "what it has without compression is read" : kPrimitive,
                                  [&] { unpack_draco(file_, primitive, packed); });
  const GltfValue mode = primitive["mode"];
  const uint64_t given = mode.whole().value_or(kTriangles);
  if (is_new && known->second && given != kTriangles && given != kStrip)
    mode.repair(mode.shown(), "4 or 5, as of compressed meshes", "triangles are read");
  return known->second || has_own;
}

uint64_t GltfMeshes::mode_of(const GltfValue& primitive) {
  const auto unpacked = unpacked_.find(primitive.path());
  // Draco holds the triangles of a strip one by one.
  if (unpacked != unpacked_.end() && unpacked->second) return kTriangles;
  return primitive["mode"].whole().value_or(kTriangles);
}

size_t GltfMeshes::number_of(const GltfValue& weights) {
  Weights given = weights.numbers(Weights(weights.size()));
  if (std::all_of(given.begin(), given.end(), [](double weight) { return weight == 0; }))
    given.clear();
  const auto [at, is_new] = weights_.try_emplace(std::move(given), by_number_.size());
  if (is_new) by_number_.push_back(&at->first);
  return at->second;
}

size_t GltfMeshes::weights(const GltfValue& node, size_t index) {
  if (const GltfValue own = node["weights"]) return number_of(own);
  const auto [at, is_new] = own_weights_.try_emplace(index, 0);
  if (is_new) at->second = number_of(file_.element("meshes", index)["weights"]);
  return at->second;
}

void GltfMeshes::list_unused_attributes() {
  for (const auto& [name, is_used] : attributes_)
    if (!is_used) warnings_.add(fmt::format("attribute {} is not used", to_utf8(name)));
}

bool GltfMeshes::has_strokes(size_t index) {
  const GltfValue primitives = file_.element("meshes", index)["primitives"];
  for (size_t i = 0; i < primitives.size(); ++i)
    if (primitives.at(i)["mode"].whole().value_or(kTriangles) < kTriangles) return true;
  return false;
}

Bounds3 GltfMeshes::bounds(size_t index) {
  const GltfValue primitives = file_.element("meshes", index)["primitives"];
  Bounds3 out;
  for (size_t i = 0; i < primitives.size(); ++i) {
    if (!unpack(primitives.at(i))) continue;
    const GltfValue reference = primitives.at(i)["attributes"]["POSITION"];
    const auto [known, is_new] =
        boxes_.try_emplace(reference.whole().value_or(file_.root()["accessors"].size()));
    Bounds3& box = known->second;
    if (is_new) {
      file_.attempt(kPrimitive, [&] {
        const auto from = GltfAccessor::read(file_, reference, kPrimitive);
        if (!from || from->components() != 3) return;
        const std::vector<float> values = from->floats(0, from->count(), 3);
        for (size_t at = 0; at + 2 < values.size(); at += 3)
          if (const Point3 p{values[at], values[at + 1], values[at + 2]}; is_finite(p - Point3{}))
            box.extend(p);
      });
    }
    out.extend(box);
  }
  return out;
}

std::vector<v1::Node> GltfMeshes::read(size_t index, size_t weights, const GltfSkin* skin,
                                       const Pen& pen) {
  const GltfValue primitives = file_.element("meshes", index)["primitives"];
  std::vector<Group> groups;
  std::map<std::string, size_t> by_key;
  for (size_t i = 0; i < primitives.size(); ++i) {
    const GltfValue primitive = primitives.at(i);
    if (!unpack(primitive)) continue;
    const uint64_t mode = mode_of(primitive);
    if (mode > kFan) {
      primitive["mode"].repair(fmt::format("{}", mode), "0 to 6", "the primitive is left out");
      continue;
    }
    const size_t each = corners_each(mode);
    // Points and lines without normals are lit by nothing (3.9.6).
    const GltfMaterialUse material{
        primitive["material"].index(file_.root()["materials"].size(), "material"),
        each < 3 && !primitive["attributes"]["NORMAL"]};
    Attributes attributes =
        attributes_of(primitive, material, *by_number_[weights], skin != nullptr);
    if (!attributes.position) {
      warnings_.add("primitives without POSITION are left out");
      continue;
    }
    std::string key = attributes.key();
    if (each < 3) key += fmt::format("{} by {}", each, materials_.use(material));
    const auto placed = by_key.try_emplace(std::move(key), groups.size());
    if (placed.second) groups.emplace_back(std::move(attributes));
    Group& group = groups[placed.first->second];
    group.corners_each = each;
    file_.attempt(kPrimitive, [&] { add(primitive, material, group); });
  }
  std::vector<v1::Node> nodes;
  for (Group& group : groups) {
    if (group.corners.empty()) continue;
    if (auto node = finish(group, skin, pen)) nodes.push_back(std::move(*node));
  }
  return nodes;
}

void GltfMeshes::add(const GltfValue& primitive, const GltfMaterialUse& material, Group& group) {
  const auto positions = GltfAccessor::read(file_, group.attributes.position, kPrimitive);
  if (!positions) return;
  if (positions->components() != 3)
    throw group.attributes.position.error("positions that are no VEC3", "VEC3");
  group.vertex_count = positions->count();
  std::vector<uint32_t> corners;
  const GltfValue given = primitive["indices"];
  if (given) {
    const auto indices = GltfAccessor::read(file_, given, kPrimitive);
    if (!indices) return;
    file_.spend(indices->count(), given);
    corners = indices->indices();
  } else {
    file_.spend(group.vertex_count, primitive);
    corners.resize(group.vertex_count);
    for (size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<uint32_t>(i);
  }
  const std::string& name = materials_.use(material);
  const auto known = std::find(group.materials.begin(), group.materials.end(), name);
  const auto number = static_cast<uint32_t>(known - group.materials.begin());
  if (known == group.materials.end()) group.materials.push_back(name);
  const uint64_t mode = mode_of(primitive);
  const size_t each = group.corners_each;
  const bool is_list = mode == kLines || mode == kTriangles;
  if (corners.size() < each || (is_list && corners.size() % each != 0))
    (given ? given : primitive)
        .repair(fmt::format("{} corners", corners.size()),
                fmt::format("{} or {}", each, is_list ? "a multiple of it" : "more"),
                "those left over are left out");
  std::optional<uint32_t> lost;
  for_each_part(mode, corners, [&](std::initializer_list<uint32_t> part) {
    const uint32_t largest = std::max(part);
    if (largest >= group.vertex_count) {
      lost = largest;
      return;
    }
    const uint32_t* const p = part.begin();
    if (part.size() > 1 && p[0] == p[1]) return;
    if (part.size() > 2 && (p[1] == p[2] || p[2] == p[0])) return;
    group.corners.insert(group.corners.end(), part);
    if (each == 3) group.face_materials.push_back(number);
  });
  if (!lost) return;
  constexpr std::array kLeftOut{"the points there are left out", "the lines there are left out",
                                "the triangles there are left out"};
  file_.attempt(kLeftOut[each - 1], [&] {
    throw given.error(fmt::format("index {} of {} vertices", *lost, group.vertex_count),
                      "indices of vertices");
  });
}

std::vector<float> GltfMeshes::rows(const GltfValue& reference, size_t width, const Group& group,
                                    size_t least) {
  constexpr std::string_view kLeftOut = "it is left out";
  if (!reference) return {};
  const auto from = GltfAccessor::read(file_, reference, kLeftOut);
  if (!from) return {};
  if (from->count() != group.vertex_count) {
    from->place().repair(fmt::format("{} rows", from->count()), "one a vertex", kLeftOut);
    return {};
  }
  if (from->components() < std::min(width, least)) {
    reference.repair(fmt::format("rows of {}", from->components()),
                     fmt::format("{} numbers a row", width), kLeftOut);
    return {};
  }
  file_.spend(uint64_t{group.last - group.first} * width, from->place());
  return from->floats(group.first, group.last, width);
}

std::vector<float> GltfMeshes::finite_rows(const GltfValue& reference, size_t width, float instead,
                                           const Group& group, size_t least) {
  std::vector<float> out = rows(reference, width, group, least);
  if (replace_endless(out, width, instead) > 0)
    reference.repair("numbers that are not finite", "finite numbers",
                     fmt::format("{} is taken", instead));
  return out;
}

/// Of a target without the attribute nothing is added.
void GltfMeshes::add_targets(const char* attribute, const Group& group, std::vector<float>& to,
                             size_t width) {
  for (const auto& [target, weight] : group.attributes.targets) {
    const GltfValue reference = target[attribute];
    if (!reference) continue;
    const std::vector<float> offsets = rows(reference, 3, group);
    for (size_t i = 0; i < offsets.size(); ++i) {
      float& moved = to[i / 3 * width + i % 3];
      moved = static_cast<float>(moved + weight * double{offsets[i]});
    }
  }
}

std::vector<GltfInfluences> GltfMeshes::influences(const Group& group, size_t joint_count) {
  constexpr size_t kWidth = 4;
  std::vector<GltfInfluences> out;
  for (const auto& [joints, weights] : group.attributes.influences) {
    GltfInfluences set{rows(joints, kWidth, group, kWidth),
                       finite_rows(weights, kWidth, 0, group, kWidth)};
    if (set.joints.empty() || set.weights.empty()) continue;
    std::optional<float> lost, below;
    for (size_t i = 0; i < set.weights.size(); ++i) {
      const float joint = set.joints[i];
      float& weight = set.weights[i];
      const bool is_there =
          joint >= 0 && joint < static_cast<float>(joint_count) && joint == std::floor(joint);
      if (weight < 0 && !below) below = weight;
      if (weight > 0 && !is_there && !lost) lost = joint;
      if (weight < 0 || !is_there) weight = 0;
    }
    if (lost)
      joints.repair(fmt::format("joint {}", *lost), fmt::format("0 to {}", joint_count - 1),
                    "its weight is left out");
    if (below) weights.repair(fmt::format("a weight of {}", *below), "0 or more", "0 is taken");
    out.push_back(std::move(set));
  }
  return out;
}

std::optional<v1::Node> GltfMeshes::finish(Group& group, const GltfSkin* skin, const Pen& pen) {
  const auto [least, most] = std::minmax_element(group.corners.begin(), group.corners.end());
  group.first = *least;
  group.last = *most + 1;
  MeshData mesh;
  const Attributes& from = group.attributes;
  mesh.positions = rows(from.position, 3, group);
  add_targets("POSITION", group, mesh.positions);
  mesh.normals = finite_rows(from.normal, 3, 0, group);
  if (!mesh.normals.empty()) {
    add_targets("NORMAL", group, mesh.normals);
    replace_endless(mesh.normals, 3, 0);
  }
  const auto uvs = [&](const GltfValue& reference) {
    std::vector<float> out = finite_rows(reference, 2, 0, group);
    for (size_t i = 1; i < out.size(); i += 2) out[i] = 1 - out[i];
    return out;
  };
  mesh.uvs = uvs(from.uv);
  mesh.second_uvs = uvs(from.second_uv);
  mesh.colors = finite_rows(from.color, 4, 1, group);
  limit_colors(from.color, mesh.colors);
  for (size_t i = 0; i < mesh.colors.size(); ++i)
    if (i % 4 != 3) mesh.colors[i] = vertex_light(mesh.colors[i], VertexColorSource::gltf);
  // Without normals a tangent says nothing (3.7.2.1).
  if (!mesh.normals.empty()) mesh.tangents = finite_rows(from.tangent, 4, 0, group);
  if (!mesh.tangents.empty()) {
    add_targets("TANGENT", group, mesh.tangents, 4);
    replace_endless(mesh.tangents, 4, 0);
    if (const size_t useless = clear_useless_tangents(mesh.normals, mesh.tangents); useless > 0)
      from.tangent.repair(
          fmt::format("{} of length 0 or along the normal", counted(useless, "tangent")),
          "directions across the normals", "there they go by the texture coordinates");
  }
  if (group.first > 0)
    for (uint32_t& index : group.corners) index -= group.first;
  const bool is_drawn = group.corners_each < 3;
  if (!is_drawn) mesh.triangles = std::move(group.corners);
  if (group.materials.size() > 1) mesh.face_materials = std::move(group.face_materials);
  if (skin) bend_mesh(*skin, influences(group, skin->joints.size()), mesh);
  if (is_drawn) {
    file_.spend(group.corners.size() * kNumbersOfStroke, from.position);
    const auto is_placed = [&](uint32_t vertex) {
      const float* const p = &mesh.positions[size_t{vertex} * 3];
      return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    };
    if (!std::all_of(group.corners.begin(), group.corners.end(), is_placed))
      from.position.repair("numbers that are not finite in single precision", "finite numbers",
                           "the points and lines there are left out");
    mesh = draw_strokes(pen, mesh, group.corners, group.corners_each);
  }
  if (drop_unplaced(mesh) > 0)
    from.position.repair("numbers that are not finite in single precision", "finite numbers",
                         "the triangles there are left out");
  if (mesh.triangles.empty()) return std::nullopt;
  v1::Node node;
  // What has no breadth hides no light.
  if (is_drawn) node.set_casts_no_shadow(true);
  for (const std::string& material : group.materials) node.mutable_shape()->add_materials(material);
  *node.mutable_shape()->mutable_mesh() = store_mesh(std::move(mesh), out_.blobs);
  return node;
}

}  // namespace tessera
