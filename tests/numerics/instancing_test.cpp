// N23: nested transforms give the hits of triangles placed in quad precision.
#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/sphere.h"
#include "tests/numerics/spawned.h"

namespace tessera::numerics {
namespace {

using N23 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N23, kSeeds);

/// Turned, scaled, sheared, often mirrored; a good way off.
Affine random_level(Random& random, double scale_exponent, double far_exponent) {
  const double scale = std::pow(10, random.uniform(-scale_exponent, scale_exponent));
  Affine shear;
  shear.m[0][1] = random.uniform(-1, 1);
  shear.m[2][0] = random.uniform(-1, 1);
  const Vec3 stretch{random.uniform(0.5, 2), random.uniform(0.5, 2), random.below(2) ? -1.0 : 1.0};
  const Affine part = random.turn() * shear * scaling(stretch * scale);
  return translation(random.direction() * std::abs(random.power(-2, far_exponent))) * part;
}

QuadVec apply(const Affine& a, const QuadVec& p) {
  const auto row = [&](size_t r) {
    return a.m[r][0] * p.x + a.m[r][1] * p.y + a.m[r][2] * p.z + a.m[r][3];
  };
  return {row(0), row(1), row(2)};
}
Vec3 apply_sizes(const Affine& a, const Vec3& p) {
  Vec3 q;
  for (int r = 0; r < 3; ++r) {
    const auto& m = a.m[size_t(r)];
    q[r] = std::abs(m[0]) * p.x + std::abs(m[1]) * p.y + std::abs(m[2]) * p.z + std::abs(m[3]);
  }
  return q;
}

/// A chain of transforms, outermost first, as one product like a scene's and one by one.
struct Nest {
  std::vector<Affine> levels;
  Transform product;

  Nest(Random& random, double far_exponent) {
    const int depth = 1 + random.below(8);
    Affine all;
    for (int i = 0; i < depth; ++i) {
      levels.push_back(random_level(random, 4.0 / depth, i == 0 ? far_exponent : 2));
      all = all * levels.back();
    }
    product = Transform(all);
  }
  QuadVec place(QuadVec p) const {
    for (size_t i = levels.size(); i-- > 0;) p = apply(levels[i], p);
    return p;
  }
  /// The sum of |M| |p| over the levels: what rounding errors are relative to.
  double size(const Point3& p) const {
    Vec3 s = abs(p - Point3{});
    for (size_t i = levels.size(); i-- > 0;) s = apply_sizes(levels[i], s);
    return length(s);
  }
  /// The same of a point that is taken into the innermost frame and out again.
  double round_trip_size(const Point3& world) const {
    return length(apply_sizes(product.matrix(),
                              apply_sizes(product.inverse_matrix(), abs(world - Point3{}))));
  }
};

Point3 rounded(const QuadVec& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

TEST_P(N23, NestedTrianglesAreHitWhereFlattenedQuadsAre) {
  Random random(23, seed());
  TraversalCounters counters;
  int64_t tested = 0;
  const int64_t tries = ray_count(1'000'000 / kShards);
  for (int64_t i = 0; i < tries; ++i) {
    const Nest nest(random, random.below(2) ? 2 : 7);
    auto mesh = std::make_shared<TriangleMesh>();
    for (int k = 0; k < 3; ++k)
      mesh->positions.push_back({static_cast<float>(random.uniform(-1, 1)),
                                 static_cast<float>(random.uniform(-1, 1)),
                                 static_cast<float>(random.uniform(-1, 1))});
    mesh->triangles = {{0, 1, 2}};
    const Instance instance{make_mesh_shape(mesh, AcceleratorKind::bvh, 1), nest.product};
    QuadVec corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = nest.place(QuadVec(mesh->vertex(uint32_t(k))));
    const QuadVec e1 = corner[1] - corner[0], e2 = corner[2] - corner[0], n = cross(e1, e2);
    const double u = random.uniform(0.1, 0.4), v = random.uniform(0.1, 0.4);
    const Point3 target = rounded(corner[0] + e1 * u + e2 * v);
    const double side = static_cast<double>(length(e1) + length(e2));
    const Point3 origin = target + random.direction() * (side * std::abs(random.power(-1, 2)));
    const Ray ray{origin, target - origin};
    const double size = nest.size(mesh->vertex(0)) + nest.size(mesh->vertex(1)) +
                        nest.round_trip_size(origin) + nest.round_trip_size(target);
    const double band = 64 * kUnitRoundoff * size;
    // Only where the error is far from the triangle's own size and the ray does not graze it.
    const QuadVec d(ray.direction);
    const double cosine = static_cast<double>(fabsq(dot(n, d)) / (length(n) * length(d)));
    if (!(static_cast<double>(length(n)) / side * cosine > 1000 * band) || cosine < 0.01) continue;
    ++tested;
    Hit hit;
    ASSERT_TRUE(closest_hit_of(instance, 0, ray, hit, counters))
        << "seed " << seed() << " at " << i << " of " << nest.levels.size() << " levels";
    const Quad exact = dot(n, corner[0] - QuadVec(origin)) / dot(n, d);
    ASSERT_LE(static_cast<double>(fabsq(exact - hit.t) * length(d)) * cosine, band)
        << "seed " << seed() << " at " << i << " of " << nest.levels.size() << " levels";
    const SurfaceInteraction s = surface_at({&instance, 1}, ray, hit);
    const Quad off = dot(n, QuadVec(s.point) - corner[0]) / length(n);
    ASSERT_LE(fabsq(off), band);
  }
  EXPECT_GT(tested, tries / 4);
}

TEST_P(N23, NestedShapesDoNotHitThemselves) {
  Random random(123, seed());
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->positions = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}};
  mesh->triangles = {{0, 1, 2}};
  const std::shared_ptr<const Shape> solids[] = {
      std::make_shared<Box>(Bounds3{{-1, -1, -1}, {1, 1, 1}}),
      std::make_shared<Sphere>(Point3{}, 1), std::make_shared<Cylinder>(1, 1),
      std::make_shared<Cone>(1, 1)};
  const std::shared_ptr<const Shape> flat = make_mesh_shape(mesh, AcceleratorKind::bvh, 1);
  Spawned count;
  for (int64_t i = 0; i < ray_count(1'000'000 / kShards); ++i) {
    const Nest nest(random, random.below(2) ? 2 : 7);
    const int kind = random.below(5);
    const std::vector<Instance> scene{{kind < 4 ? solids[kind] : flat, nest.product}};
    const Point3 target = nest.product.point(Point3{0, 0.3, 0.15} + random.in_cube(0.1));
    const Point3 origin = nest.product.point(Point3{} + random.direction() * 5);
    leave(scene, {origin, target - origin}, kind < 4, random, count);
  }
  EXPECT_GT(count.rays, ray_count(2'000'000 / kShards));
  EXPECT_EQ(count.self_hits, 0) << "of " << count.rays << " seed " << seed() << ": " << count.first;
}

}  // namespace
}  // namespace tessera::numerics
