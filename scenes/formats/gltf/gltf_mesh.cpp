#include "scenes/formats/gltf/gltf_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/mesh/mesh_data.h"

namespace tessera {
namespace {

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
  for (const GltfValue* value : {&position, &normal, &uv, &color}) {
    const auto index = value->whole();
    key += index ? fmt::format("{} ", *index) : "- ";
  }
  for (const auto& [target, weight] : targets)
    for (const char* attribute : {"POSITION", "NORMAL"}) {
      const auto index = target[attribute].whole();
      key += index ? fmt::format("{} ", *index) : "- ";
    }
  return key;
}

GltfMeshes::Attributes GltfMeshes::attributes_of(const GltfValue& primitive,
                                                 std::optional<size_t> material,
                                                 const Weights& weights) {
  const GltfValue in = primitive["attributes"];
  const std::string uv = fmt::format("TEXCOORD_{}", materials_.uv_set(material));
  Attributes out{in["POSITION"], in["NORMAL"], in[uv.c_str()], in["COLOR_0"], {}};
  const GltfValue targets = primitive["targets"];
  if (!weights.empty() && targets.size() != weights.size())
    throw primitive.error(fmt::format("{} morph targets", targets.size()),
                          fmt::format("{}, one a weight", weights.size()));
  for (size_t i = 0; i < weights.size(); ++i)
    if (weights[i] != 0) out.targets.emplace_back(targets.at(i), weights[i]);
  return out;
}

size_t GltfMeshes::number_of(const GltfValue& weights) {
  Weights given = weights.numbers(weights.size()).value_or(Weights{});
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

std::vector<v1::Shape> GltfMeshes::read(size_t index, size_t weights) {
  const GltfValue primitives = file_.element("meshes", index)["primitives"];
  std::vector<Group> groups;
  std::map<std::string, size_t> by_key;
  for (size_t i = 0; i < primitives.size(); ++i) {
    const GltfValue primitive = primitives.at(i);
    const uint64_t mode = primitive["mode"].whole().value_or(kTriangles);
    if (mode > kFan) throw primitive["mode"].error(fmt::format("{}", mode), "0 to 6");
    if (mode < kTriangles) {
      warnings_.add("points and lines have no surface and are left out");
      continue;
    }
    const auto material = primitive["material"].index(file_.root()["materials"].size(), "material");
    Attributes attributes = attributes_of(primitive, material, *by_number_[weights]);
    if (!attributes.position) {
      warnings_.add("primitives without POSITION are left out");
      continue;
    }
    const auto [at, is_new] = by_key.try_emplace(attributes.key(), groups.size());
    if (is_new) groups.emplace_back(std::move(attributes));
    add(primitive, material, groups[at->second]);
  }
  std::vector<v1::Shape> shapes;
  for (Group& group : groups)
    if (!group.triangles.empty()) shapes.push_back(finish(group));
  return shapes;
}

void GltfMeshes::add(const GltfValue& primitive, std::optional<size_t> material, Group& group) {
  const GltfAccessor positions(file_, group.attributes.position);
  if (positions.components() != 3)
    throw group.attributes.position.error("positions that are no VEC3", "VEC3");
  group.vertex_count = positions.count();
  std::vector<uint32_t> corners;
  const GltfValue given = primitive["indices"];
  if (given) {
    const GltfAccessor indices(file_, given);
    file_.spend(indices.count(), given);
    corners = indices.indices();
    for (size_t i = 0; i < corners.size(); ++i)
      if (corners[i] >= group.vertex_count)
        throw given.error(fmt::format("index {} is {}", i, corners[i]),
                          group.vertex_count == 0 ? std::string("vertices")
                                                  : fmt::format("0 to {}", group.vertex_count - 1));
  } else {
    file_.spend(group.vertex_count, primitive);
    corners.resize(group.vertex_count);
    for (size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<uint32_t>(i);
  }
  const std::string& name = materials_.use(material);
  const auto known = std::find(group.materials.begin(), group.materials.end(), name);
  const auto number = static_cast<uint32_t>(known - group.materials.begin());
  if (known == group.materials.end()) group.materials.push_back(name);
  for_each_triangle(primitive["mode"].whole().value_or(kTriangles), corners,
                    [&](uint32_t a, uint32_t b, uint32_t c) {
                      if (a == b || b == c || c == a) return;
                      group.triangles.insert(group.triangles.end(), {a, b, c});
                      group.face_materials.push_back(number);
                    });
}

std::vector<float> GltfMeshes::rows(const GltfAccessor& from, size_t width, const Group& group) {
  if (from.count() != group.vertex_count)
    throw from.place().error(fmt::format("{} rows", from.count()),
                             fmt::format("{}, one a vertex", group.vertex_count));
  file_.spend(uint64_t{group.last - group.first} * width, from.place());
  return from.floats(group.first, group.last, width);
}

/// Of a target without the attribute nothing is added.
void GltfMeshes::add_targets(const char* attribute, const Group& group, std::vector<float>& to) {
  for (const auto& [target, weight] : group.attributes.targets) {
    const GltfValue reference = target[attribute];
    if (!reference) continue;
    const GltfAccessor from(file_, reference);
    if (from.components() != 3) throw reference.error("offsets that are no VEC3", "VEC3");
    const std::vector<float> offsets = rows(from, 3, group);
    for (size_t i = 0; i < to.size(); ++i) {
      const double sum = to[i] + weight * double{offsets[i]};
      if (!(std::abs(sum) <= std::numeric_limits<float>::max()))
        throw target.error(
            fmt::format("{} beyond single precision with weight {}", attribute, weight), "less");
      to[i] = static_cast<float>(sum);
    }
  }
}

v1::Shape GltfMeshes::finish(Group& group) {
  const auto [least, most] = std::minmax_element(group.triangles.begin(), group.triangles.end());
  group.first = *least;
  group.last = *most + 1;
  MeshData mesh;
  const Attributes& from = group.attributes;
  mesh.positions = rows(GltfAccessor(file_, from.position), 3, group);
  add_targets("POSITION", group, mesh.positions);
  if (from.normal) {
    mesh.normals = rows(GltfAccessor(file_, from.normal), 3, group);
    add_targets("NORMAL", group, mesh.normals);
  }
  if (from.uv) {
    mesh.uvs = rows(GltfAccessor(file_, from.uv), 2, group);
    for (size_t i = 1; i < mesh.uvs.size(); i += 2) mesh.uvs[i] = 1 - mesh.uvs[i];
  }
  if (from.color) mesh.colors = rows(GltfAccessor(file_, from.color), 4, group);
  if (group.first > 0)
    for (uint32_t& index : group.triangles) index -= group.first;
  mesh.triangles = std::move(group.triangles);
  if (group.materials.size() > 1) mesh.face_materials = std::move(group.face_materials);
  v1::Shape shape;
  for (const std::string& material : group.materials) shape.add_materials(material);
  *shape.mutable_mesh() = store_mesh(std::move(mesh), out_.blobs);
  return shape;
}

}  // namespace tessera
