// N24: shadow rays are stopped by what is between their ends, and by nothing else.
#include "renderer/accel/make_accelerator.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/sphere.h"
#include "tests/numerics/spawned.h"

namespace tessera::numerics {
namespace {

using N24 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N24, kSeeds);

TriangleMesh box_mesh(const Vec3& half) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({static_cast<float>(i & 1 ? half.x : -half.x),
                              static_cast<float>(i & 2 ? half.y : -half.y),
                              static_cast<float>(i & 4 ? half.z : -half.z)});
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

/// Convex, so that nothing stands between a point of the surface and what is outward of it.
std::shared_ptr<const Shape> convex(int kind, Random& random) {
  const double a = random.uniform(0.2, 1), b = random.uniform(0.2, 1);
  switch (kind) {
    case 0:
      return std::make_shared<Sphere>(Point3{}, a);
    case 1:
      return std::make_shared<Box>(Bounds3{{-a, -b, -1}, {a, b, 1}});
    case 2:
      return std::make_shared<Cylinder>(a, 2 * b);
    case 3:
      return std::make_shared<Cone>(a, 2 * b);
    case 4:
      return std::make_shared<Disc>(Point3{}, random.direction(), a);
    default:
      return make_mesh_shape(std::make_shared<const TriangleMesh>(box_mesh({a, b, 1})),
                             AcceleratorKind::bvh, 1);
  }
}
constexpr int kConvexKinds = 6;

/// Some point of the surface of the only instance, seen from outside.
std::optional<SurfaceInteraction> some_surface(const std::vector<Instance>& scene, Random& random) {
  const Transform& place = scene[0].world_from_object;
  const Point3 origin = place.point(Point3{} + random.direction() * 4);
  const Ray ray{origin, place.point(Point3{} + random.in_cube(0.1)) - origin};
  Hit hit;
  TraversalCounters counters;
  if (!closest_hit_of(scene[0], 0, ray, hit, counters)) return std::nullopt;
  SurfaceInteraction s = surface_at(scene, ray, hit);
  if (dot(s.geometric_normal, ray.direction) > 0) s.geometric_normal = -s.geometric_normal;
  return s;
}

/// To the side of the normal, often grazing.
Vec3 outward(const SurfaceInteraction& s, Random& random) {
  const Vec3 n = static_cast<Vec3>(s.geometric_normal);
  Vec3 d = random.direction();
  if (random.below(2)) d = across(n, random) + n * std::abs(random.power(-8, -1));
  return dot(d, n) < 0 ? -d : d;
}

TEST_P(N24, NothingShadesAConvexShapeFromALightOutsideOfIt) {
  Random random(24, seed());
  TraversalCounters counters;
  int64_t tested = 0, shaded = 0;
  for (int64_t i = 0; i < ray_count(10'000'000 / kShards / 4); ++i) {
    const double size = std::abs(random.power(-3, 3));
    std::vector<Instance> scene{{convex(random.below(kConvexKinds), random)}};
    if (random.below(2)) scene[0].world_from_object = random_affine(random, 3);
    if (random.below(4) == 0) scene[0].world_from_object = Transform(scaling({size, size, size}));
    const auto s = some_surface(scene, random);
    if (!s) continue;
    const double unit = length(bounds_of(scene[0]).diagonal());
    for (int k = 0; k < 4; ++k) {
      // As near as the distance can still be told from the rounding of the place itself.
      const double least = 1e4 * length(s->point_error) / unit;
      const double far = std::max(std::pow(10, random.uniform(-6, 6)), least);
      const Vec3 d = normalize(outward(*s, random));
      const double height = dot(d, static_cast<Vec3>(s->geometric_normal)) * far * unit;
      if (height < 64 * length(s->point_error)) continue;
      ++tested;
      shaded += any_hit_of(scene[0], spawn_ray_to(*s, s->point + d * (far * unit)), counters);
    }
  }
  EXPECT_EQ(shaded, 0) << "of " << tested << ", seed " << seed();
  EXPECT_GT(tested, ray_count(4'000'000 / kShards));
}

TEST_P(N24, NothingShadesAnEmitterFromWhatItFaces) {
  // From one surface to the place that a ray would leave the other from.
  Random random(124, seed());
  TraversalCounters counters;
  int64_t tested = 0, shaded = 0;
  for (int64_t i = 0; i < ray_count(10'000'000 / kShards); ++i) {
    const double far = std::pow(10, random.uniform(-6, 6));
    const double scale = std::abs(random.power(-3, 3));
    const Transform frame(translation(random.direction() * scale * random.uniform(0, 10)) *
                          random.turn() * scaling({scale, scale, scale}));
    const std::vector<Instance> floor{{std::make_shared<Disc>(Point3{}, Vec3{0, 1, 0}, 1), frame}};
    const std::vector<Instance> lamp{
        {std::make_shared<Disc>(Point3{0, far, 0}, Vec3{0, -1, 0}, 1 + far), frame}};
    const auto at = [&](const std::vector<Instance>& scene, double y, double side) {
      const Point3 target{random.uniform(-0.6, 0.6), y, random.uniform(-0.6, 0.6)};
      const Point3 origin = frame.point(target + Vec3{0, side * std::min(far, 1.0) / 2, 0});
      const Ray ray{origin, frame.point(target) - origin};
      Hit hit;
      EXPECT_TRUE(closest_hit_of(scene[0], 0, ray, hit, counters));
      return surface_at(scene, ray, hit);
    };
    const SurfaceInteraction lit = at(floor, 0, 1);
    SurfaceInteraction emits = at(lamp, far, -1);
    if (!(far * scale > 1e4 * (length(lit.point_error) + length(emits.point_error)))) continue;
    // Where the stretch ends is known to rounding of its own length only, here and in the frame.
    emits.point_error = emits.point_error + abs(lit.point - emits.point) * gamma(12);
    const Ray to_lit = spawn_ray(emits, lit.point - emits.point);
    const Ray shadow = spawn_ray_to(lit, to_lit.origin);
    ++tested;
    shaded += any_hit_of(floor[0], shadow, counters) || any_hit_of(lamp[0], shadow, counters);
  }
  EXPECT_EQ(shaded, 0) << "of " << tested << ", seed " << seed();
  EXPECT_GT(tested, ray_count(8'000'000 / kShards));
}

TEST_P(N24, NoLightLeavesAClosedBox) {
  Random random(224, seed());
  int64_t leaks = 0, rays = 0;
  std::string first;
  for (int number = 0; number < 16; ++number) {
    const Transform place = number == 0 ? Transform{} : random_affine(random, 3);
    const auto mesh = std::make_shared<const TriangleMesh>(box_mesh({1, 0.5, 0.75}));
    std::vector<Accelerators> boxes;
    for (const AcceleratorKind kind :
         {AcceleratorKind::linear, AcceleratorKind::bvh, AcceleratorKind::octree}) {
      const auto shape = make_mesh_shape(mesh, kind, 1);
      // Three in a row, so that there is a tree above too; all rays stay near the first.
      boxes.push_back(Accelerators::over(
          std::vector<Instance>{{shape, place},
                                {shape, Transform(place.matrix() * translation({10, 0, 0}))},
                                {shape, Transform(place.matrix() * translation({0, 10, 0}))}}));
    }
    for (int64_t i = 0; i < ray_count(10'000'000 / kShards / 16); ++i) {
      // From inside, through an edge, a corner or a face, to a light outside.
      const Point3 inside{random.uniform(-0.9, 0.9), random.uniform(-0.4, 0.4),
                          random.uniform(-0.7, 0.7)};
      const auto c = mesh->corners(random.below(mesh->triangles.size()));
      const Point3 through = c[0] + (c[1] - c[0]) * (0.25 * random.below(5));
      const double beyond = 1 + std::abs(random.power(-6, 3));
      const Point3 light = place.point(inside + (through - inside) * beyond);
      const Point3 origin = place.point(inside);
      const Vec3 d = light - origin;
      for (const Ray& ray : {Ray{origin, d, 0, 1}, Ray{light, -d, 0, 1}}) {
        for (const Accelerators& set : boxes) {
          for (const auto& accelerator : set.all) {
            TraversalCounters counters;
            ++rays;
            if (!accelerator->any_hit(ray, counters) && leaks++ == 0) first = describe(ray);
          }
        }
      }
    }
  }
  EXPECT_EQ(leaks, 0) << "of " << rays << ", seed " << seed() << ": " << first;
}

}  // namespace
}  // namespace tessera::numerics
