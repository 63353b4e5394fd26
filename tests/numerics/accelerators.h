#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "renderer/accel/bvh.h"
#include "renderer/accel/embree_mesh.h"
#include "renderer/accel/few_instances.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/octree.h"
#include "renderer/accel/tree_boxes.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/triangle_mesh.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {

inline bool has_embree() {
  const std::array<float, 6> box{0, 0, 0, 1, 1, 1};
  return make_embree_boxes({&box, 1}, 1) != nullptr;
}

/// Left out of fast_anywhere: the linear scan, and Embree, whose boxes all overlap where a mesh is
/// far from the origin.
enum class Which { all, fast_anywhere };

/// The linear scan, the BVH compiled for every instruction set of this machine, both octrees, and,
/// where it is there, Embree.
struct Accelerators {
  std::vector<std::unique_ptr<const Accelerator>> all;  ///< the oracle first

  static Accelerators over(const std::shared_ptr<const TriangleMesh>& mesh,
                           Which which = Which::all) {
    Accelerators a;
    if (which == Which::all) a.all.push_back(std::make_unique<MeshLinearScan>(mesh));
    for (const BvhKernels& code : all_kernels())
      a.all.push_back(std::make_unique<MeshBvh>(*mesh, 2, code));
    a.all.push_back(std::make_unique<MeshBvh>(*mesh, 2, kernels(), BvhQuality::spatial_splits));
    for (const OctreeKind kind : {OctreeKind::uniform, OctreeKind::nonuniform})
      a.all.push_back(std::make_unique<MeshOctree>(*mesh, kind, 2));
    if (which == Which::fast_anywhere) return a;
    if (auto embree = EmbreeMesh::make(mesh, 2)) a.all.push_back(std::move(embree));
    return a;
  }
  static Accelerators over(const std::vector<Instance>& instances) {
    Accelerators a;
    a.all.push_back(std::make_unique<InstanceLinearScan>(instances));
    size_t bounded = 0;
    for (const Instance& i : instances) bounded += can_be_held(i, bounds_of(i));
    if (bounded <= BoxSoA::kMost)
      for (const BvhKernels& code : all_kernels())
        a.all.push_back(std::make_unique<FewInstances>(instances, code));
    if (bounded == 0) return a;
    for (const BvhKernels& code : all_kernels())
      a.all.push_back(std::make_unique<InstanceBvh>(instances, 2, code));
    for (const OctreeKind kind : {OctreeKind::uniform, OctreeKind::nonuniform})
      a.all.push_back(std::make_unique<InstanceOctree>(instances, kind, 2));
    return a;
  }
};

/// How many accelerators give an answer other than the first, bit for bit.
inline int disagreements(const Accelerators& accelerators, const Ray& ray) {
  TraversalCounters counters;
  int count = 0;
  Hit expected;
  const bool expected_found = accelerators.all[0]->closest_hit(ray, expected, counters);
  const bool expected_any = accelerators.all[0]->any_hit(ray, counters);
  for (size_t i = 1; i < accelerators.all.size(); ++i) {
    Hit hit;
    const bool found = accelerators.all[i]->closest_hit(ray, hit, counters);
    const bool any = accelerators.all[i]->any_hit(ray, counters);
    if (found != expected_found || any != expected_any || !(hit == expected)) ++count;
  }
  return count;
}

/// The 56 directions of components 0, -0, 1 and -1.
inline std::vector<Vec3> axis_directions() {
  std::vector<Vec3> all;
  const double parts[4] = {0.0, -0.0, 1.0, -1.0};
  for (const double x : parts)
    for (const double y : parts)
      for (const double z : parts)
        if (x != 0 || y != 0 || z != 0) all.push_back({x, y, z});
  return all;
}

inline std::string describe(const Ray& r) {
  char text[400];
  std::snprintf(text, sizeof text, "origin {%a, %a, %a} direction {%a, %a, %a}", r.origin.x,
                r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z);
  return text;
}

/// Sphere of radius 2 as an n x n grid of quads in which each vertex but the poles and the seam
/// stands off by its own random factor: PBRT's watertightness mesh.
inline TriangleMesh bumpy_sphere(uint32_t n, Random& random) {
  TriangleMesh mesh;
  const double pi = 3.14159265358979323846;
  const auto place = [&](double theta, double phi, double r) {
    mesh.positions.push_back({static_cast<float>(r * std::sin(theta) * std::cos(phi)),
                              static_cast<float>(r * std::cos(theta)),
                              static_cast<float>(r * std::sin(theta) * std::sin(phi))});
  };
  place(0, 0, 2);
  place(pi, 0, 2);
  for (uint32_t row = 1; row < n; ++row)
    for (uint32_t column = 0; column < n; ++column)
      place(pi * row / n, 2 * pi * column / n, 2 + 5 * random.uniform());
  const auto at = [n](uint32_t row, uint32_t column) {
    return row == 0 ? 0u : row == n ? 1u : 2 + (row - 1) * n + column % n;
  };
  for (uint32_t row = 0; row < n; ++row) {
    for (uint32_t column = 0; column < n; ++column) {
      const uint32_t a = at(row, column), b = at(row, column + 1);
      const uint32_t c = at(row + 1, column), d = at(row + 1, column + 1);
      if (a != b) mesh.triangles.push_back({a, b, d});
      if (c != d) mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

inline TriangleMesh moved(TriangleMesh mesh, double scale, const Vec3& by) {
  for (Float3& p : mesh.positions) {
    p = {static_cast<float>(p.x * scale + by.x), static_cast<float>(p.y * scale + by.y),
         static_cast<float>(p.z * scale + by.z)};
  }
  drop_degenerate(mesh);
  return mesh;
}

}  // namespace tessera::numerics
