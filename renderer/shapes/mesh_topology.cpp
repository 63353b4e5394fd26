// Whether a mesh is closed, and how often lines cross it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "base/cancellation.h"
#include "renderer/shapes/mesh_boundary.h"
#include "renderer/shapes/projected_edge.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {
namespace {

/// For each vertex the number of the first one at its place.
std::vector<uint32_t> weld(const TriangleMesh& mesh) {
  std::vector<uint32_t> order(mesh.positions.size()), same(order.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](uint32_t i) {
    const Point3 p = mesh.vertex(i);
    return std::tuple(p.x, p.y, p.z);
  };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return place(a) != place(b) ? place(a) < place(b) : a < b;
  });
  for (size_t i = 0; i < order.size(); ++i)
    same[order[i]] =
        i > 0 && place(order[i]) == place(order[i - 1]) ? same[order[i - 1]] : order[i];
  return same;
}

}  // namespace

void merge_vertices(TriangleMesh& mesh, double distance) {
  // Vertices that stay, by cubes of that side: those near a point are in its own or beside it.
  using Cube = std::array<double, 3>;
  struct Hash {
    size_t operator()(const Cube& cube) const {
      constexpr size_t kOdd = 0x9e3779b97f4a7c15;  // 2^64 divided by the golden ratio
      size_t mixed = 0;
      for (const double side : cube) mixed = (mixed ^ std::hash<double>()(side)) * kOdd;
      return mixed ^ mixed >> 32;
    }
  };
  std::unordered_map<Cube, std::vector<uint32_t>, Hash> staying;
  const auto cube_of = [distance](const Point3& p) {
    return Cube{std::floor(p.x / distance), std::floor(p.y / distance), std::floor(p.z / distance)};
  };
  constexpr uint32_t kBetweenLooks = 4096;
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
    if (i % kBetweenLooks == 0) Cancellation::check();
    const Point3 p = mesh.vertex(i);
    const Cube own = cube_of(p);
    uint32_t first = i;
    const auto look_in = [&](const Cube& cube) {
      const auto found = staying.find(cube);
      if (found == staying.end()) return;
      for (const uint32_t other : found->second)
        if (other < first && length(mesh.vertex(other) - p) <= distance) first = other;
    };
    constexpr double kBeside[] = {-1, 0, 1};
    for (const double x : kBeside)
      for (const double y : kBeside)
        for (const double z : kBeside) look_in({own[0] + x, own[1] + y, own[2] + z});
    if (first == i)
      staying[own].push_back(i);
    else
      mesh.positions[i] = mesh.positions[first];
  }
}

std::vector<OpenEdge> open_edges(const TriangleMesh& mesh) {
  const std::vector<uint32_t> same = weld(mesh);
  Cancellation::check();
  std::vector<std::tuple<uint32_t, uint32_t, int>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = same[t[k]], b = same[t[(k + 1) % 3]];
      if (a != b) edges.emplace_back(std::min(a, b), std::max(a, b), a < b ? 1 : -1);
    }
  }
  Cancellation::check();
  std::sort(edges.begin(), edges.end());
  Cancellation::check();
  std::vector<OpenEdge> open;
  for (size_t i = 0; i < edges.size();) {
    int sum = 0;
    const auto [a, b, first] = edges[i];
    for (; i < edges.size() && std::get<0>(edges[i]) == a && std::get<1>(edges[i]) == b; ++i)
      sum += std::get<2>(edges[i]);
    open.insert(open.end(), static_cast<size_t>(std::abs(sum)),
                sum > 0 ? OpenEdge{a, b} : OpenEdge{b, a});
  }
  return open;
}

bool is_closed(const TriangleMesh& mesh) {
  const auto has_edge = [&mesh](const TriangleIndices& t) {
    const auto place = [&mesh](uint32_t i) { return mesh.vertex(i); };
    return place(t[0]) != place(t[1]) || place(t[1]) != place(t[2]);
  };
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), has_edge) &&
         open_edges(mesh).empty();
}

int mesh_crossing_number(const TriangleMesh& mesh, const Ray& ray, std::span<const Hit> hits) {
  const TriangleRay frame(ray);
  int sum = 0;
  for (const Hit& hit : hits) {
    const auto corners = mesh.corners(hit.primitive);
    const ProjectedVertex a = project(frame, corners[0]), b = project(frame, corners[1]),
                          c = project(frame, corners[2]);
    const int side = edge_side(a, b);
    if (side == edge_side(b, c) && side == edge_side(c, a)) sum += side;
  }
  return sum;
}

}  // namespace tessera
