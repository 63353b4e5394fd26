#include "scenes/formats/gltf/gltf_skin.h"

#include <fmt/format.h>

#include <utility>

#include "scenes/formats/gltf/gltf_accessor.h"
#include "scenes/formats/gltf/gltf_transform.h"

namespace tessera {
namespace {

constexpr std::string_view kUnbent = "the mesh is shown unbent";
constexpr size_t kMatrixNumbers = 16;

/// One after another, column by column; nothing, with a warning, where they cannot be read.
std::optional<std::vector<float>> read_matrices(GltfFile& file, const GltfValue& reference,
                                                size_t count) {
  const auto from = GltfAccessor::read(file, reference, kUnbent);
  if (!from) return std::nullopt;
  if (from->components() != kMatrixNumbers || from->count() < count)
    throw from->place().error(fmt::format("{} rows of {}", from->count(), from->components()),
                              fmt::format("a MAT4 for each of {} joints", count));
  file.spend(uint64_t{count} * kMatrixNumbers, from->place());
  return from->floats(0, count, kMatrixNumbers);
}

/// The weighted mean of the matrices at a vertex.
Affine blend(const GltfSkin& skin, const std::vector<GltfInfluences>& influences, size_t vertex) {
  Affine sum;
  sum.m = {};
  double total = 0;
  for (const GltfInfluences& set : influences)
    for (size_t i = vertex * 4; i < vertex * 4 + 4; ++i) {
      const double weight = set.weights[i];
      if (weight <= 0) continue;
      const Affine& joint = skin.joints[static_cast<size_t>(set.joints[i])];
      for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column)
          sum.m[row][column] += weight * joint.m[row][column];
      total += weight;
    }
  if (total == 0) return skin.rest;
  for (auto& row : sum.m)
    for (double& number : row) number /= total;
  return sum;
}

/// Of unit length; a vector of no length stays so.
Vec3 direction(const Vec3& vec) { return length_squared(vec) > 0 ? normalize(vec) : vec; }

}  // namespace

std::vector<Affine> read_gltf_joints(GltfFile& file, const GltfValue& skin,
                                     const std::function<const Affine*(size_t node)>& world_of) {
  std::vector<Affine> out;
  const bool is_read = file.attempt(kUnbent, [&] {
    const GltfValue joints = skin["joints"], binds = skin["inverseBindMatrices"];
    const size_t count = joints.size();
    if (count == 0) throw skin.error("no joints", "at least one");
    std::optional<std::vector<float>> matrices;
    if (binds && !(matrices = read_matrices(file, binds, count))) return;
    for (size_t i = 0; i < count; ++i) {
      const GltfValue joint = joints.at(i);
      const auto node = joint.required_whole();
      const Affine* const world = world_of(node);
      if (!world) throw joint.error(fmt::format("node {}", node), "a node of the scene");
      Affine bind;
      if (matrices) {
        const auto begin = matrices->begin() + static_cast<std::ptrdiff_t>(i * kMatrixNumbers);
        bind = gltf_matrix(std::vector<double>(begin, begin + kMatrixNumbers), binds);
      }
      out.push_back(*world * bind);
      if (!is_finite(out.back()))
        throw joint.error("a joint whose matrix is not finite", "finite numbers");
    }
  });
  return is_read ? std::move(out) : std::vector<Affine>{};
}

void bend_mesh(const GltfSkin& skin, const std::vector<GltfInfluences>& influences,
               MeshData& mesh) {
  std::vector<bool> is_mirrored(mesh.vertex_count());
  for (size_t vertex = 0; vertex < is_mirrored.size(); ++vertex) {
    const Affine to = blend(skin, influences, vertex);
    const size_t at = vertex * 3;
    put_vec(to(Point3{} + vec_at(mesh.positions, at)) - Point3{}, mesh.positions, at);
    is_mirrored[vertex] = to.determinant() < 0;
    const double side = is_mirrored[vertex] ? -1 : 1;
    if (!mesh.normals.empty()) {
      // By the inverse transpose, but for a factor: the cofactors.
      const Vec3 x = to(Vec3{1, 0, 0}), y = to(Vec3{0, 1, 0}), z = to(Vec3{0, 0, 1});
      const Vec3 n = vec_at(mesh.normals, at);
      const Vec3 bent = cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z;
      put_vec(direction(bent * side), mesh.normals, at);
    }
    if (!mesh.tangents.empty()) {
      put_vec(direction(to(vec_at(mesh.tangents, vertex * 4))), mesh.tangents, vertex * 4);
      mesh.tangents[vertex * 4 + 3] *= static_cast<float>(side);
    }
  }
  for (size_t i = 0; i < mesh.triangles.size(); i += 3)
    if (is_mirrored[mesh.triangles[i]]) std::swap(mesh.triangles[i + 1], mesh.triangles[i + 2]);
}

}  // namespace tessera
