#include "renderer/shapes/triangle_mesh.h"

#include <atomic>
#include <cmath>
#include <numeric>

#include "base/parallel.h"
#include "renderer/math/rounding.h"

namespace tessera {
namespace {

#include "renderer/shapes/triangle-inl.h"

/// Of unit length. Corners in a line have no normal of their own: any that is square to the line
/// serves the rare ray that rounding lets hit there.
Vec3 unit_normal(const std::array<Point3, 3>& corner) {
  const Vec3 e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  const Vec3 n = accurate_cross(e1, e2);
  if (max_component(abs(n)) > 0) return normalize(n);
  const Vec3 line = normalize(e1);
  return normalize(cross(line, std::abs(line.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
}

bool finite(const Float3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

Vec3 to_vec(const Float3& v) { return {v.x, v.y, v.z}; }

void add_uv(std::span<const Float2> uvs, const TriangleIndices& index,
            const std::array<Point3, 3>& corner, const std::array<double, 3>& weight, Vec2& uv,
            Vec3& dpdu, Vec3& dpdv) {
  const Float2 a = uvs[index[0]], b = uvs[index[1]], c = uvs[index[2]];
  uv = {weight[0] * a.x + weight[1] * b.x + weight[2] * c.x,
        weight[0] * a.y + weight[1] * b.y + weight[2] * c.y};
  const double du1 = double{b.x} - a.x, dv1 = double{b.y} - a.y;
  const double du2 = double{c.x} - a.x, dv2 = double{c.y} - a.y;
  const double det = difference_of_products(du1, dv2, dv1, du2);
  if (det == 0) return;
  const Vec3 e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  dpdu = (e1 * dv2 - e2 * dv1) / det;
  dpdv = (e2 * du1 - e1 * du2) / det;
}

/// bitangent = cross(normal, tangent.xyz) * tangent.w (Khronos, glTF 2.0 specification, 3.7.2.1).
void add_tangent(const TriangleMesh& mesh, const TriangleIndices& index,
                 const std::array<double, 3>& weight, LocalSurface& surface) {
  Vec3 tangent;
  double side = 0;
  for (size_t k = 0; k < 3; ++k) {
    const Float4& t = mesh.tangents[index[k]];
    tangent = tangent + Vec3{t.x, t.y, t.z} * weight[k];
    side += weight[k] * t.w;
  }
  surface.tangent = tangent;
  surface.bitangent =
      cross(static_cast<Vec3>(surface.shading_normal), tangent) * (side < 0 ? -1 : 1);
}

/// From the facet to the curved surface between the tangent planes of its vertices, where that is
/// on the normals' side (Hanika, Ray Tracing Gems II, 4).
Vec3 smooth_shift(const TriangleMesh& mesh, const TriangleIndices& index,
                  const std::array<Point3, 3>& corner, const std::array<double, 3>& weight,
                  const Point3& point) {
  Vec3 shift;
  for (size_t k = 0; k < 3; ++k) {
    const Vec3 n = to_vec(mesh.normals[index[k]]);
    const double below = -dot(point - corner[k], n), squared = dot(n, n);
    if (below > 0 && squared > 0) shift = shift + n * (weight[k] * below / squared);
  }
  return shift;
}

bool is_legal(const TriangleMesh& mesh, size_t triangle) {
  for (const uint32_t index : mesh.triangles[triangle]) {
    if (index >= mesh.positions.size() || !finite(mesh.positions[index])) return false;
  }
  const auto [a, b, c] = mesh.corners(triangle);
  return a != b && b != c && c != a;
}

/// As those of most meshes are, which then need not be written again.
bool all_legal(const TriangleMesh& mesh, int threads) {
  constexpr size_t kPiece = 1 << 16;
  std::atomic<bool> legal{true};
  for_each_piece_parallel(mesh.triangles.size(), kPiece, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (!is_legal(mesh, i)) legal = false;
    }
  });
  return legal;
}

}  // namespace

Bounds3 TriangleMesh::bounds() const {
  Bounds3 box;
  for (const TriangleIndices& triangle : triangles)
    for (const uint32_t index : triangle) box.extend(vertex(index));
  return box;
}

size_t TriangleMesh::bytes() const {
  return positions.size() * sizeof(Float3) + triangles.size() * sizeof(TriangleIndices) +
         normals.size() * sizeof(Float3) + (uvs.size() + second_uvs.size()) * sizeof(Float2) +
         (colors.size() + tangents.size()) * sizeof(Float4) +
         (face_materials.size() + original_numbers.size()) * sizeof(uint32_t);
}

MeshDefects drop_degenerate(TriangleMesh& mesh, int threads) {
  MeshDefects defects;
  if (all_legal(mesh, threads)) return defects;
  size_t kept = 0;
  if (mesh.original_numbers.empty()) {
    mesh.original_numbers.resize(mesh.triangles.size());
    std::iota(mesh.original_numbers.begin(), mesh.original_numbers.end(), 0u);
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const TriangleIndices index = mesh.triangles[i];
    const size_t n = mesh.positions.size();
    if (index[0] >= n || index[1] >= n || index[2] >= n) {
      ++defects.bad_index;
    } else if (!(finite(mesh.positions[index[0]]) && finite(mesh.positions[index[1]]) &&
                 finite(mesh.positions[index[2]]))) {
      ++defects.not_finite;
    } else {
      const auto [a, b, c] = mesh.corners(i);
      if (a == b || b == c || c == a) {
        ++defects.coincident;
        continue;
      }
      mesh.triangles[kept] = index;
      mesh.original_numbers[kept] = mesh.original_numbers[i];
      if (!mesh.face_materials.empty()) mesh.face_materials[kept] = mesh.face_materials[i];
      ++kept;
    }
  }
  mesh.triangles.resize(kept);
  mesh.original_numbers.resize(kept);
  if (!mesh.face_materials.empty()) mesh.face_materials.resize(kept);
  return defects;
}

LocalSurface triangle_surface(const TriangleMesh& mesh, uint32_t triangle, double u, double v) {
  const TriangleIndices& index = mesh.triangles[triangle];
  const std::array<Point3, 3> corner = mesh.corners(triangle);
  const std::array<double, 3> weight{1 - u - v, u, v};
  LocalSurface surface;
  Vec3 point;
  place_on_triangle({to_vec(corner[0]), to_vec(corner[1]), to_vec(corner[2])},
                    {weight[0], weight[1], weight[2]}, point, surface.point_error);
  surface.point = to_point(point);
  surface.geometric_normal = to_normal(unit_normal(corner));
  surface.shading_normal = surface.geometric_normal;
  if (!mesh.normals.empty()) {
    const Vec3 n = blend({to_vec(mesh.normals[index[0]]), to_vec(mesh.normals[index[1]]),
                          to_vec(mesh.normals[index[2]])},
                         {weight[0], weight[1], weight[2]});
    if (is_normal(n)) {
      surface.shading_normal = to_normal(normalize(n));
      const Vec3 shift = smooth_shift(mesh, index, corner, weight, surface.point);
      if (is_finite(shift)) surface.smooth_shift = shift;
    }
  }
  if (!mesh.uvs.empty())
    add_uv(mesh.uvs, index, corner, weight, surface.uv, surface.dpdu, surface.dpdv);
  if (!mesh.second_uvs.empty()) {
    add_uv(mesh.second_uvs, index, corner, weight, surface.second_uv, surface.second_dpdu,
           surface.second_dpdv);
    surface.has_second_uv = true;
  }
  if (!mesh.tangents.empty()) add_tangent(mesh, index, weight, surface);
  if (!mesh.colors.empty()) {
    const auto blend = [&](float Float4::*channel) {
      return weight[0] * mesh.colors[index[0]].*channel +
             weight[1] * mesh.colors[index[1]].*channel +
             weight[2] * mesh.colors[index[2]].*channel;
    };
    surface.vertex_color = {blend(&Float4::x), blend(&Float4::y), blend(&Float4::z)};
    // Where all three are 1 it is 1, so that no light comes through by rounding.
    const double alpha = mesh.colors[index[0]].w;
    surface.vertex_alpha = alpha + weight[1] * (mesh.colors[index[1]].w - alpha) +
                           weight[2] * (mesh.colors[index[2]].w - alpha);
    surface.has_vertex_color = true;
  }
  if (!mesh.face_materials.empty()) surface.material = mesh.face_materials[triangle];
  return surface;
}

}  // namespace tessera
