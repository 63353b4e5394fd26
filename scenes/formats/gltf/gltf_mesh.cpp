#include "scenes/formats/gltf/gltf_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/file.h"
#include "scenes/mesh/mesh_data.h"
#include "scenes/mesh/vertex_colors.h"

namespace tessera {
namespace {

constexpr std::string_view kPrimitive = "the primitive is left out";

enum Mode : uint64_t { kTriangles = 4, kStrip = 5, kFan = 6 };

/// The corners of a primitive in groups of three. Calls action for each, flat ones too.
template <typename Action>
void for_each_triangle(uint64_t mode, const std::vector<uint32_t>& corners, const Action& action) {
  const size_t n = corners.size();
  if (mode == kTriangles) {
    for (size_t i = 0; i + 2 < n; i += 3) action(corners[i], corners[i + 1], corners[i + 2]);
    return;
  }
  for (size_t i = 0; i + 2 < n; ++i) {
    if (mode == kFan)
      action(corners[i + 1], corners[i + 2], corners[0]);
    else if (i % 2 == 0)
      action(corners[i], corners[i + 1], corners[i + 2]);
    else
      action(corners[i + 1], corners[i], corners[i + 2]);
  }
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

}  // namespace

/// The primitives of one shape.
struct GltfMeshes::Group {
  explicit Group(Attributes from) : attributes(std::move(from)) {}

  Attributes attributes;
  size_t vertex_count = 0;
  std::vector<std::string> materials;
  std::vector<uint32_t> triangles, face_materials;
  uint32_t first = 0, last = 0;  ///< the vertices that are used: [first, last)
};

std::string GltfMeshes::Attributes::key() const {
  std::string key;
  for (const GltfValue* value : {&position, &normal, &uv, &color, &tangent}) {
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
                                                 std::optional<size_t> material,
                                                 const Weights& weights, bool is_bent) {
  const GltfValue in = primitive["attributes"];
  const auto use = [&](const std::string& name) {
    attributes_[name] = true;
    return in[name.c_str()];
  };
  std::string uv = fmt::format("TEXCOORD_{}", materials_.uv_set(material));
  if (!in[uv.c_str()] && in["TEXCOORD_0"]) {
    in.repair("no " + uv, "the texture coordinates that its material uses", "TEXCOORD_0 is taken");
    uv = "TEXCOORD_0";
  }
  Attributes out{use("POSITION"), use("NORMAL"), use(uv), use("COLOR_0"), use("TANGENT"), {}, {}};
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

std::vector<v1::Shape> GltfMeshes::read(size_t index, size_t weights, const GltfSkin* skin) {
  const GltfValue primitives = file_.element("meshes", index)["primitives"];
  std::vector<Group> groups;
  std::map<std::string, size_t> by_key;
  for (size_t i = 0; i < primitives.size(); ++i) {
    const GltfValue primitive = primitives.at(i);
    const uint64_t mode = primitive["mode"].whole().value_or(kTriangles);
    if (mode > kFan) {
      primitive["mode"].repair(fmt::format("{}", mode), "0 to 6", "the primitive is left out");
      continue;
    }
    if (mode < kTriangles) {
      warnings_.add("points and lines have no surface and are left out");
      continue;
    }
    const auto material = primitive["material"].index(file_.root()["materials"].size(), "material");
    Attributes attributes =
        attributes_of(primitive, material, *by_number_[weights], skin != nullptr);
    if (!attributes.position) {
      warnings_.add("primitives without POSITION are left out");
      continue;
    }
    const auto placed = by_key.try_emplace(attributes.key(), groups.size());
    if (placed.second) groups.emplace_back(std::move(attributes));
    Group& group = groups[placed.first->second];
    file_.attempt(kPrimitive, [&] { add(primitive, material, group); });
  }
  std::vector<v1::Shape> shapes;
  for (Group& group : groups) {
    if (group.triangles.empty()) continue;
    if (auto shape = finish(group, skin)) shapes.push_back(std::move(*shape));
  }
  return shapes;
}

void GltfMeshes::add(const GltfValue& primitive, std::optional<size_t> material, Group& group) {
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
  const uint64_t mode = primitive["mode"].whole().value_or(kTriangles);
  if (corners.size() < 3 || (mode == kTriangles && corners.size() % 3 != 0))
    (given ? given : primitive)
        .repair(fmt::format("{} corners", corners.size()),
                mode == kTriangles ? "3 or a multiple of it" : "3 or more",
                "those left over are left out");
  std::optional<uint32_t> lost;
  for_each_triangle(mode, corners, [&](uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t largest = std::max({a, b, c});
    if (largest >= group.vertex_count) {
      lost = largest;
      return;
    }
    if (a == b || b == c || c == a) return;
    group.triangles.insert(group.triangles.end(), {a, b, c});
    group.face_materials.push_back(number);
  });
  if (!lost) return;
  file_.attempt("the triangles there are left out", [&] {
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

std::optional<v1::Shape> GltfMeshes::finish(Group& group, const GltfSkin* skin) {
  const auto [least, most] = std::minmax_element(group.triangles.begin(), group.triangles.end());
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
  mesh.uvs = finite_rows(from.uv, 2, 0, group);
  for (size_t i = 1; i < mesh.uvs.size(); i += 2) mesh.uvs[i] = 1 - mesh.uvs[i];
  mesh.colors = finite_rows(from.color, 4, 1, group);
  limit_colors(from.color, mesh.colors);
  for (size_t i = 0; i < mesh.colors.size(); ++i)
    if (i % 4 != 3) mesh.colors[i] = vertex_light(mesh.colors[i], VertexColorSource::gltf);
  // Without normals a tangent says nothing (3.7.2.1).
  if (!mesh.normals.empty()) mesh.tangents = finite_rows(from.tangent, 4, 0, group);
  if (!mesh.tangents.empty()) {
    add_targets("TANGENT", group, mesh.tangents, 4);
    replace_endless(mesh.tangents, 4, 0);
  }
  if (group.first > 0)
    for (uint32_t& index : group.triangles) index -= group.first;
  mesh.triangles = std::move(group.triangles);
  if (group.materials.size() > 1) mesh.face_materials = std::move(group.face_materials);
  if (skin) bend_mesh(*skin, influences(group, skin->joints.size()), mesh);
  if (drop_unplaced(mesh) > 0)
    from.position.repair("numbers that are not finite in single precision", "finite numbers",
                         "the triangles there are left out");
  if (mesh.triangles.empty()) return std::nullopt;
  v1::Shape shape;
  for (const std::string& material : group.materials) shape.add_materials(material);
  *shape.mutable_mesh() = store_mesh(std::move(mesh), out_.blobs);
  return shape;
}

}  // namespace tessera
