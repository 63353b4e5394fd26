// N13 and N02 for closed meshes as operands of CSG.
#include <gtest/gtest.h>

#include "base/error.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/closed_mesh.h"
#include "renderer/shapes/csg_shape.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"
#include "renderer/shapes/triangle.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {
namespace {

std::shared_ptr<TriangleMesh> box_mesh(const Bounds3& b) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (int i = 0; i < 8; ++i)
    mesh->positions.push_back({float(i & 1 ? b.max.x : b.min.x), float(i & 2 ? b.max.y : b.min.y),
                               float(i & 4 ? b.max.z : b.min.z)});
  mesh->triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                     {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

/// An octahedron, each triangle cut into four `levels` times, with bumps.
std::shared_ptr<TriangleMesh> bumpy_ball(int levels, double bump, Random& random) {
  auto mesh = std::make_shared<TriangleMesh>();
  const int n = 1 << levels;
  // On a grid over the octahedron's faces; equal places get equal bumps by their grid numbers.
  const auto vertex = [&](int x, int y, int z) {
    uint32_t key =
        uint32_t(x + n) * 73856093u ^ uint32_t(y + n) * 19349663u ^ uint32_t(z + n) * 83492791u;
    key = (key ^ (key >> 13)) * 1274126177u;
    const double r = 1 + bump * (key >> 8) * 0x1p-24;
    const Vec3 v = normalize(Vec3{double(x), double(y), double(z)}) * r;
    mesh->positions.push_back({float(v.x), float(v.y), float(v.z)});
    return uint32_t(mesh->positions.size() - 1);
  };
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
    const bool flip = sx * sy * sz < 0;
    const auto at = [&](int i, int j) { return vertex(sx * i, sy * j, sz * (n - i - j)); };
    const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
      if (flip)
        mesh->triangles.push_back({a, c, b});
      else
        mesh->triangles.push_back({a, b, c});
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
  for (size_t i = mesh->triangles.size(); i-- > 1;)
    std::swap(mesh->triangles[i], mesh->triangles[random.below(i + 1)]);
  return mesh;
}

/// A ray from near the centre, or from outside, through a vertex or a point of an edge.
Ray through_edges(const TriangleMesh& mesh, const Point3& from, Random& random) {
  const auto c = mesh.corners(random.below(mesh.triangles.size()));
  const double steps[] = {0, 0.25, 0.5, 0.75, 1, random.uniform()};
  const Point3 at = c[0] + (c[1] - c[0]) * steps[random.below(6)];
  return {from, at - from};
}

TEST(N02, ClosedMeshesAreCrossedEvenlyThroughEdgesAndVertices) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(2, seed);
    for (const double bump : {0.0, 0.3, 5.0}) {
      const auto mesh = bumpy_ball(3, bump, random);
      const ClosedMesh solid(mesh);
      CsgTree tree;
      const auto root = tree.add(std::make_shared<ClosedMesh>(mesh));
      const CsgShape csg(tree, root);
      for (int64_t i = 0; i < ray_count(400000); ++i) {
        const bool inside = i % 2;
        const Point3 from = Point3{} + random.direction() * (inside ? random.uniform(0, 0.2)
                                                                    : random.uniform(7, 20));
        const Ray ray = through_edges(*mesh, from, random);
        std::vector<SolidEvent> events;
        solid.crossings(ray, {}, events);
        int winding = 0, ahead = 0;
        for (const SolidEvent& e : events) {
          winding += e.entering ? 1 : -1;
          if (e.t > 0) ahead += e.entering ? -1 : 1;
        }
        ASSERT_EQ(winding, 0) << "seed " << seed << " at " << i;
        ASSERT_EQ(ahead, inside ? 1 : 0) << "seed " << seed << " at " << i;
        Hit hit;
        TraversalCounters counters;
        if (inside) {
          ASSERT_TRUE(csg.closest_hit(ray, hit, counters));
        }
      }
    }
  }
}

TEST(N13, MeshAndSolidThatCoincide) {
  const Bounds3 extent{{-1, -0.5, -0.75}, {1, 0.5, 0.75}};
  const auto mesh = std::make_shared<ClosedMesh>(box_mesh(extent));
  const auto box = std::make_shared<Box>(extent);
  Random random(26);
  TraversalCounters counters;
  for (int64_t i = 0; i < ray_count(40000); ++i) {
    const Affine turn = translation(random.direction()) * random.turn();
    const auto combine = [&](CsgOperation operation, bool mesh_first) {
      CsgTree tree;
      const auto a =
          tree.add(mesh_first ? std::shared_ptr<const Shape>(mesh) : box, Transform(turn));
      const auto b =
          tree.add(mesh_first ? std::shared_ptr<const Shape>(box) : mesh, Transform(turn));
      return CsgShape(tree, tree.combine(operation, std::vector{a, b}));
    };
    const CsgShape nothing = combine(CsgOperation::subtract, i % 2);
    const CsgShape both = combine(CsgOperation::intersect, i % 2);
    const CsgShape either = combine(CsgOperation::join, i % 2);
    for (int k = 0; k < 100; ++k) {
      const Point3 target = Transform(turn).point(
          {random.uniform(-1.1, 1.1), random.uniform(-0.6, 0.6), random.uniform(-0.8, 0.8)});
      const Vec3 d = random.direction();
      const Ray ray{target - d * 5, d};
      Hit h, a, b, c;
      ASSERT_FALSE(nothing.closest_hit(ray, h, counters));
      const Transform place(turn);
      const bool found = box->closest_hit(
          {place.inverse_point(ray.origin), place.inverse_vector(ray.direction)}, a, counters);
      // A graze of an edge may be seen or not.
      if (found != both.closest_hit(ray, b, counters) ||
          found != either.closest_hit(ray, c, counters)) {
        std::vector<SolidEvent> events;
        box->crossings({place.inverse_point(ray.origin), place.inverse_vector(ray.direction)}, {},
                       events);
        ASSERT_TRUE(events.empty() || events[1].t - events[0].t < 1e-13) << "at " << i;
        continue;
      }
      if (!found) continue;
      ASSERT_NEAR(a.t, b.t, 1e-13);
      ASSERT_NEAR(a.t, c.t, 1e-13);
    }
  }
}

TEST(N10, SliversInCombinationsDoNotHitThemselves) {
  int64_t tested = 0, self_hits = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(27, seed);
    for (int64_t i = 0; i < ray_count(200000); ++i) {
      const double exponents[] = {0.5, 2, 4, 6};
      const double e = exponents[random.below(4)];
      auto mesh = std::make_shared<TriangleMesh>();
      for (int k = 0; k < 4; ++k)
        mesh->positions.push_back(
            {float(random.power(-e, e)), float(random.power(-e, e)), float(random.power(-e, e))});
      mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
      CsgTree tree;
      CsgTree::Node root;
      try {
        root = tree.add(std::make_shared<ClosedMesh>(mesh));
      } catch (const Error&) {
        continue;
      }
      const CsgShape shape(tree, root);
      const auto c = mesh->corners(size_t(random.below(4)));
      const double u = random.uniform(0, 0.5), v = random.uniform(0, 0.5);
      const Point3 target = c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v;
      const Vec3 d = random.direction();
      const Ray ray{target - d * (size_of(target) * random.uniform(0.1, 3) + 1e-6), d};
      Hit hit;
      TraversalCounters counters;
      if (!shape.closest_hit(ray, hit, counters)) continue;
      const SurfaceInteraction s = shape.surface(ray, hit);
      const Vec3 n = static_cast<Vec3>(s.geometric_normal);
      Vec3 away = random.direction();
      if (dot(away, n) < 0) away = -away;
      ++tested;
      // A tetrahedron is convex.
      if (shape.any_hit(spawn_ray(s, away), counters)) ++self_hits;
    }
  }
  EXPECT_EQ(self_hits, 0);
  EXPECT_GT(tested, ray_count(200000));
}

TEST(ClosedMesh, RefusesWhatIsOpenAndTurnsWhatIsInsideOut) {
  const Bounds3 extent{{-1, -1, -1}, {1, 1, 1}};
  auto open = box_mesh(extent);
  open->triangles.pop_back();
  EXPECT_THROW(ClosedMesh{open}, Error);
  auto one_turned = box_mesh(extent);
  std::swap(one_turned->triangles[3][0], one_turned->triangles[3][1]);
  EXPECT_THROW(ClosedMesh{one_turned}, Error);
  EXPECT_THROW(ClosedMesh{std::make_shared<TriangleMesh>()}, Error);
  auto turned = box_mesh(extent);
  for (TriangleIndices& t : turned->triangles) std::swap(t[0], t[1]);
  for (const auto& mesh : {box_mesh(extent), turned}) {
    const ClosedMesh solid(mesh);
    const Ray ray{{0.3, 0.2, 5}, {0, 0, -1}};
    std::vector<SolidEvent> events;
    solid.crossings(ray, {}, events);
    ASSERT_EQ(events.size(), 2u);
    EXPECT_TRUE(events[0].entering);
    EXPECT_NEAR(events[0].t, 4, 1e-14);
    EXPECT_FALSE(events[1].entering);
    const Hit hit{events[0].t, events[0].u, events[0].v, 0, events[0].primitive};
    EXPECT_EQ(solid.surface(ray, hit).geometric_normal.z, 1);
  }
}

TEST(ClosedMesh, ItsTreeLosesNothing) {
  Random random(28);
  const auto mesh = bumpy_ball(5, 0.5, random);
  const ClosedMesh solid(mesh);
  TraversalCounters counters;
  for (int i = 0; i < 2000; ++i) {
    const Ray ray = through_edges(*mesh, Point3{} + random.direction() * 4, random);
    Hit expected, hit;
    const TriangleRay frame(ray);
    for (uint32_t t = 0; t < mesh->triangles.size(); ++t) {
      const auto [a, b, c] = mesh->corners(t);
      TriangleHit at;
      if (intersect_triangle(frame, a, b, c, at) &&
          (at.t < expected.t || (at.t == expected.t && t < expected.primitive)))
        expected = {at.t, at.u, at.v, 0, t};
    }
    counters = {};
    solid.closest_hit(ray, hit, counters);
    ASSERT_EQ(hit, expected);
    ASSERT_LT(counters.primitive_tests, mesh->triangles.size() / 10);
  }
}

}  // namespace
}  // namespace tessera::numerics
