#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "renderer/math/elementary.h"
#include "renderer/math/vec.h"
#include "scenes/generate/generate_scene.h"
#include "scenes/generate/random.h"

namespace tessera {
namespace {

/// Points and triangles over them while a mesh is being made.
struct Surface {
  std::vector<Vec3> points;
  std::vector<std::array<uint32_t, 3>> triangles;
};

MeshData to_mesh(const Surface& surface, bool smooth) {
  MeshData mesh;
  mesh.positions.reserve(surface.points.size() * 3);
  for (const Vec3& p : surface.points)
    for (int a = 0; a < 3; ++a) mesh.positions.push_back(static_cast<float>(p[a]));
  if (smooth) mesh.normals = mesh.positions;
  mesh.triangles.reserve(surface.triangles.size() * 3);
  for (const auto& t : surface.triangles)
    mesh.triangles.insert(mesh.triangles.end(), t.begin(), t.end());
  return mesh;
}

Surface icosahedron() {
  const double g = 1.618033988749895;
  Surface s;
  for (const Vec3& p : {Vec3{-1, g, 0},
                        {1, g, 0},
                        {-1, -g, 0},
                        {1, -g, 0},
                        {0, -1, g},
                        {0, 1, g},
                        {0, -1, -g},
                        {0, 1, -g},
                        {g, 0, -1},
                        {g, 0, 1},
                        {-g, 0, -1},
                        {-g, 0, 1}})
    s.points.push_back(normalize(p));
  s.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  return s;
}

Surface subdivided(const Surface& from) {
  Surface to;
  to.points = from.points;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  const auto middle = [&](uint32_t a, uint32_t b) {
    const auto [at, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(to.points.size()));
    if (is_new) to.points.push_back(normalize(to.points[a] + to.points[b]));
    return at->second;
  };
  for (const auto& [a, b, c] : from.triangles) {
    const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    to.triangles.push_back({a, ab, ca});
    to.triangles.push_back({b, bc, ab});
    to.triangles.push_back({c, ca, bc});
    to.triangles.push_back({ab, bc, ca});
  }
  return to;
}

}  // namespace

MeshData icosphere(int subdivisions, bool smooth) {
  Surface surface = icosahedron();
  for (int i = 0; i < std::clamp(subdivisions, 0, 10); ++i) surface = subdivided(surface);
  return to_mesh(surface, smooth);
}

MeshData triangle_soup(uint32_t count, double size, uint64_t seed) {
  Random random(seed);
  Surface surface;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3 center = random.in_cube();
    const uint32_t first = 3 * i;
    for (int k = 0; k < 3; ++k) surface.points.push_back(center + random.in_cube() * size);
    surface.triangles.push_back({first, first + 1, first + 2});
  }
  return to_mesh(surface, false);
}

MeshData uv_sphere(uint32_t rings, uint32_t segments) {
  Surface surface;
  surface.points.push_back({0, 1, 0});
  for (uint32_t r = 1; r < rings; ++r) {
    const double polar = portable::kPi * r / rings;
    for (uint32_t s = 0; s < segments; ++s) {
      const double around = 2 * portable::kPi * s / segments;
      surface.points.push_back({portable::sin(polar) * portable::sin(around), portable::cos(polar),
                                portable::sin(polar) * portable::cos(around)});
    }
  }
  surface.points.push_back({0, -1, 0});
  const auto last = static_cast<uint32_t>(surface.points.size() - 1);
  const auto at = [&](uint32_t r, uint32_t s) { return 1 + (r - 1) * segments + s % segments; };
  for (uint32_t s = 0; s < segments; ++s) surface.triangles.push_back({0, at(1, s), at(1, s + 1)});
  for (uint32_t r = 1; r + 1 < rings; ++r) {
    for (uint32_t s = 0; s < segments; ++s) {
      surface.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      surface.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  for (uint32_t s = 0; s < segments; ++s)
    surface.triangles.push_back({last, at(rings - 1, s + 1), at(rings - 1, s)});
  return to_mesh(surface, true);
}

MeshData diamond() {
  Surface surface;
  surface.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  surface.triangles = {{0, 2, 4}, {4, 2, 1}, {1, 2, 5}, {5, 2, 0},
                       {4, 3, 0}, {1, 3, 4}, {5, 3, 1}, {0, 3, 5}};
  return to_mesh(surface, false);
}

}  // namespace tessera
