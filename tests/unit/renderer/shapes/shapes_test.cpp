#include <gtest/gtest.h>

#include <numbers>
#include <optional>

#include "renderer/shapes/box.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"
#include "renderer/shapes/triangle.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {
namespace {

TraversalCounters counters;

std::optional<Hit> closest(const Shape& shape, const Ray& ray) {
  Hit hit;
  if (!shape.closest_hit(ray, hit, counters)) return std::nullopt;
  EXPECT_TRUE(shape.any_hit(ray, counters));
  return hit;
}

TEST(TriangleMesh, BitangentsGoWithTheTransform) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  mesh.tangents = {{0, 1, 0, -1}, {0, 1, 0, -1}, {0, 1, 0, -1}};
  LocalSurface s = triangle_surface(mesh, 0, .25, .25);
  EXPECT_EQ(s.tangent, (Vec3{0, 1, 0}));
  EXPECT_EQ(s.bitangent, (Vec3{1, 0, 0})) << "cross(n, t) * w";
  take_to_world(Transform(scaling({-2, 1, 1})), false, 0, s);
  EXPECT_EQ(s.tangent, (Vec3{0, 1, 0}));
  EXPECT_EQ(s.bitangent, (Vec3{-2, 0, 0})) << "mirrored with the picture";
}

TEST(Sphere, MeetsNearThenFarSide) {
  const Sphere sphere({0, 0, -5}, 2);
  EXPECT_EQ(closest(sphere, {{0, 0, 0}, {0, 0, -1}})->t, 3);
  EXPECT_EQ(closest(sphere, {{0, 0, 0}, {0, 0, -2}})->t, 1.5);  // t counts in directions
  EXPECT_EQ(closest(sphere, {{0, 0, -5}, {0, 0, -1}})->t, 2);
  EXPECT_FALSE(closest(sphere, {{0, 0, 0}, {0, 0, 1}}));
  EXPECT_FALSE(closest(sphere, {{0, 2.1, 0}, {0, 0, -1}}));
  Ray ray{{0, 0, 0}, {0, 0, -1}};
  ray.t_min = 3;
  EXPECT_EQ(closest(sphere, ray)->t, 7);  // the interval is open
  ray.t_max = 7;
  EXPECT_FALSE(closest(sphere, ray));
}

TEST(Sphere, CullsBySide) {
  const Sphere sphere({0, 0, 0}, 1);
  Ray ray{{0, 0, 3}, {0, 0, -1}};
  ray.cull = Cull::front;
  EXPECT_EQ(closest(sphere, ray)->t, 4);
  ray.cull = Cull::back;
  EXPECT_EQ(closest(sphere, ray)->t, 2);
  ray.origin = {0, 0, 0};
  EXPECT_FALSE(closest(sphere, ray));
}

TEST(Sphere, SurfaceHasNormalAndTextureCoordinatesOfX3d) {
  const Sphere sphere({1, 2, 3}, 2);
  const Ray ray{{1, 2, 9}, {0, 0, -1}};
  const LocalSurface s = sphere.surface(ray, *closest(sphere, ray));
  EXPECT_EQ(s.point, (Point3{1, 2, 5}));
  EXPECT_EQ(s.geometric_normal, (Normal3{0, 0, 1}));
  EXPECT_DOUBLE_EQ(s.uv.x, 0.5);  // the seam is at -z
  EXPECT_DOUBLE_EQ(s.uv.y, 0.5);
  const Ray left{{-9, 2, 3}, {1, 0, 0}};
  EXPECT_DOUBLE_EQ(sphere.surface(left, *closest(sphere, left)).uv.x, 0.25);
}

/// That `b` is `a` without texture coordinates.
void expect_bare(const LocalSurface& a, const LocalSurface& b) {
  EXPECT_EQ(a.point, b.point);
  EXPECT_EQ(a.point_error, b.point_error);
  EXPECT_EQ(a.geometric_normal, b.geometric_normal);
  EXPECT_NE(a.uv, Vec2{});
  EXPECT_EQ(b.uv, Vec2{});
  EXPECT_EQ(b.dpdu, Vec3{});
}

TEST(Sphere, WithoutTextureCoordinatesTheRestStays) {
  const Sphere full({1, 2, 3}, 2), bare({1, 2, 3}, 2, false);
  const Ray ray{{0.5, 2.5, 9}, {0.05, -0.1, -1}};
  Hit hit;
  ASSERT_TRUE(bare.closest_hit(ray, hit, counters));
  expect_bare(full.surface(ray, hit), bare.surface(ray, hit));
}

TEST(Plane, SeesItsFrontAndItsBack) {
  const Plane plane({0, 2, 0}, 1);
  Ray down{{0, 4, 0}, {1, -1, 0}};
  EXPECT_EQ(closest(plane, down)->t, 3);
  EXPECT_EQ(plane.surface(down, *closest(plane, down)).point, (Point3{3, 1, 0}));
  EXPECT_FALSE(closest(plane, {{0, 4, 0}, {1, 0, 0}}));
  EXPECT_FALSE(closest(plane, {{0, 4, 0}, {0, 1, 0}}));
  down.cull = Cull::front;
  EXPECT_FALSE(closest(plane, down));
  down.cull = Cull::back;
  EXPECT_TRUE(closest(plane, down));
}

TEST(Plane, WithoutTextureCoordinatesTheRestStays) {
  const Plane full({0.1, 2, 0.3}, 1), bare({0.1, 2, 0.3}, 1, false);
  const Ray ray{{2, 4, 0}, {1, -1, 0}};
  expect_bare(full.surface(ray, *closest(full, ray)), bare.surface(ray, *closest(bare, ray)));
}

TEST(Box, ReportsFaces) {
  const Box box({{-1, -2, -3}, {1, 2, 3}});
  const Vec3 towards[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (uint32_t face = 0; face < 6; ++face) {
    const Ray ray{Point3{} - towards[face] * 10, towards[face]};
    const std::optional<Hit> hit = closest(box, ray);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->primitive, face);
    const LocalSurface s = box.surface(ray, *hit);
    EXPECT_EQ(static_cast<Vec3>(s.geometric_normal), -towards[face]);
    EXPECT_DOUBLE_EQ(s.uv.x, 0.5);
    EXPECT_DOUBLE_EQ(s.uv.y, 0.5);
    EXPECT_EQ(dot(s.dpdu, s.geometric_normal), 0);
    EXPECT_GT(dot(cross(s.dpdu, s.dpdv), s.geometric_normal), 0);  // upright from outside
    EXPECT_EQ(closest(box, {{0, 0, 0}, -towards[face]})->primitive, face);
  }
  EXPECT_FALSE(closest(box, {{0, 0, 9}, {1, 0, 0}}));
}

TEST(Triangle, CullsByWinding) {
  const Point3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  for (const Vec3& turned : {Vec3{0.1, 0.2, -1}, Vec3{-0.3, 0.1, 1}}) {
    Ray ray{Point3{0.2, 0.3, 0} - turned * 4, turned};
    const bool front = turned.z < 0;  // the normal is +z
    for (const Cull cull : {Cull::none, Cull::back, Cull::front}) {
      ray.cull = cull;
      TriangleHit hit;
      const bool expected = cull == Cull::none || (cull == Cull::back) == front;
      EXPECT_EQ(intersect_triangle(TriangleRay(ray), a, b, c, hit), expected);
      if (!expected) continue;
      EXPECT_DOUBLE_EQ(hit.t, 4);
      EXPECT_NEAR(hit.u, 0.2, 1e-15);
      EXPECT_NEAR(hit.v, 0.3, 1e-15);
    }
  }
}

TEST(Triangle, ARoundedZeroFarAwayIsNoHit) {
  // A sliver at distance 1 from the ray that points at it: two edge functions round to zero.
  const Point3 a{1, 1, 0}, b{1 + 0x1p-30, 1 + 0x1p-30, 0}, c{1 + 0x1p-29, 1 + 0x1p-29 + 0x1p-52, 0};
  TriangleHit hit;
  EXPECT_FALSE(intersect_triangle(TriangleRay({{0, 0, 5}, {0, 0, -1}}), a, b, c, hit));
}

TEST(TriangleMesh, InterpolatesWhatItHas) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  mesh.triangles = {{0, 1, 2}};
  LocalSurface s = triangle_surface(mesh, 0, 0.25, 0.5);
  EXPECT_EQ(s.point, (Point3{0.5, 1, 0}));
  EXPECT_EQ(s.geometric_normal, (Normal3{0, 0, 1}));
  EXPECT_EQ(s.shading_normal, s.geometric_normal);
  EXPECT_FALSE(s.has_vertex_color);
  EXPECT_EQ(s.dpdu, Vec3{});
  EXPECT_EQ(s.material, 0u);
  mesh.normals = {{1, 0, 1}, {1, 0, 1}, {1, 0, 1}};
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  mesh.colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 0}};
  mesh.face_materials = {7};
  s = triangle_surface(mesh, 0, 0.25, 0.5);
  EXPECT_NEAR(s.shading_normal.x, std::numbers::sqrt2 / 2, 1e-15);
  EXPECT_EQ(s.uv, (Vec2{0.25, 0.5}));
  EXPECT_EQ(s.dpdu, (Vec3{2, 0, 0}));
  EXPECT_EQ(s.dpdv, (Vec3{0, 2, 0}));
  EXPECT_EQ(s.vertex_color, (Color{0.25, 0.25, 0.5}));
  EXPECT_EQ(s.vertex_alpha, 0.5);
  EXPECT_EQ(s.material, 7u);
}

TEST(TriangleMesh, DroppingKeepsFaceMaterialsBeside) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  mesh.triangles = {{0, 1, 1}, {0, 1, 2}, {0, 1, 9}};
  mesh.face_materials = {4, 5, 6};
  EXPECT_EQ(drop_degenerate(mesh).total(), 2u);
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.face_materials, std::vector<uint32_t>{5});
}

}  // namespace
}  // namespace tessera
