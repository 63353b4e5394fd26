// N17, N22: what is scaled, turned, mirrored or listed in another order is hit in the same places.
#include <xmmintrin.h>

#include <functional>

#include "bench/generated_meshes.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/sphere.h"
#include "tests/numerics/accelerators.h"

namespace tessera::numerics {
namespace {

using N17 = Shard;
using N22 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N17, kSeeds);
INSTANTIATE_TEST_SUITE_P(Seed, N22, kSeeds);

/// Coordinates with few digits, so that they stay exact where floats are denormal.
TriangleMesh coarse(TriangleMesh mesh) {
  for (Float3& p : mesh.positions)
    p = {std::round(p.x * 4096) / 4096, std::round(p.y * 4096) / 4096,
         std::round(p.z * 4096) / 4096};
  drop_degenerate(mesh);
  return mesh;
}

template <typename Change>
TriangleMesh changed(TriangleMesh mesh, const Change& change) {
  for (Float3& p : mesh.positions) p = change(p);
  return mesh;
}

TriangleMesh scaled(const TriangleMesh& mesh, int exponent) {
  return changed(mesh, [exponent](const Float3& p) {
    return Float3{std::ldexp(p.x, exponent), std::ldexp(p.y, exponent), std::ldexp(p.z, exponent)};
  });
}
Ray scaled(const Ray& ray, int exponent) {
  const double k = std::ldexp(1.0, exponent);
  return {Point3{} + (ray.origin - Point3{}) * k, ray.direction * k, ray.t_min, ray.t_max};
}

/// Towards a vertex, an edge or anywhere.
Ray random_ray(const TriangleMesh& mesh, Random& random) {
  const Point3 origin = Point3{} + random.in_cube(4);
  if (random.below(2)) return {origin, random.direction()};
  const auto c = mesh.corners(random.below(mesh.triangles.size()));
  return {origin, c[0] + (c[1] - c[0]) * (0.25 * random.below(5)) - origin};
}

/// Hits of the first mesh by the scan, of the second by every accelerator.
template <typename Check>
void compare(const TriangleMesh& a, const TriangleMesh& b, Random& random, int64_t rays,
             const std::function<Ray(const Ray&)>& change, const Check& check) {
  const MeshLinearScan scan(std::make_shared<const TriangleMesh>(a));
  const Accelerators all = Accelerators::over(std::make_shared<const TriangleMesh>(b));
  int64_t hits = 0;
  for (int64_t i = 0; i < rays; ++i) {
    const Ray ray = random_ray(a, random);
    TraversalCounters counters;
    Hit expected;
    const bool found = scan.closest_hit(ray, expected, counters);
    hits += found;
    for (const auto& accelerator : all.all) {
      SCOPED_TRACE(&accelerator - all.all.data());
      Hit hit;
      ASSERT_EQ(accelerator->closest_hit(change(ray), hit, counters), found) << describe(ray);
      ASSERT_EQ(accelerator->any_hit(change(ray), counters), found) << describe(ray);
      if (found) check(expected, hit, ray);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  EXPECT_GT(hits, rays / 10);
}

/// Flushes denormal floats and doubles to zero while it lives, as some hosts do by default.
class FlushToZero {
 public:
  explicit FlushToZero(bool on) : before_(_mm_getcsr()) {
    if (on) _mm_setcsr(before_ | 0x8040);
  }
  ~FlushToZero() { _mm_setcsr(before_); }

 private:
  unsigned before_;
};

TEST_P(N17, MeshesOfDenormalsAreHitAsTheirScaledCopies) {
  Random random(17, seed());
  const TriangleMesh mesh = coarse(icosphere(2));
  for (const int exponent : {-100, -126, -131, 100, 120}) {
    SCOPED_TRACE(exponent);
    compare(
        mesh, scaled(mesh, exponent), random, ray_count(1'000'000 / kShards / 5),
        [=](const Ray& ray) { return scaled(ray, exponent); },
        [](const Hit& a, const Hit& b, const Ray& ray) { ASSERT_EQ(a, b) << describe(ray); });
  }
}

TEST_P(N17, FlushingDenormalsToZeroChangesNoAnswerForOrdinaryNumbers) {
  Random random(117, seed());
  const TriangleMesh mesh = icosphere(2);
  const FlushToZero flush(true);
  compare(
      mesh, mesh, random, ray_count(1'000'000 / kShards), [](const Ray& ray) { return ray; },
      [](const Hit& a, const Hit& b, const Ray& ray) { ASSERT_EQ(a, b) << describe(ray); });
}

/// Shapes of doubles so small or large that squares leave the range: never NaN, never a hit outside
/// of the box.
TEST_P(N17, ShapesAtTheEndsOfTheRangeSpreadNoNaN) {
  Random random(217, seed());
  TraversalCounters counters;
  for (int64_t i = 0; i < ray_count(1'000'000 / kShards); ++i) {
    const int exponent = random.below(2) ? -1030 : 500;
    const double size = std::ldexp(1.0, exponent + random.below(20));
    const std::shared_ptr<const Shape> shapes[] = {
        std::make_shared<Sphere>(Point3{}, size),
        std::make_shared<Box>(Bounds3{{-size, -size, -size}, {size, size, size}})};
    const Ray ray{Point3{} + random.in_cube(4 * size), random.direction() * size};
    for (const auto& shape : shapes) {
      Hit hit;
      if (!shape->closest_hit(ray, hit, counters)) continue;
      ASSERT_FALSE(std::isnan(hit.t));
      const LocalSurface s = shape->surface(ray, hit);
      for (int a = 0; a < 3; ++a) ASSERT_FALSE(std::isnan(s.point[a]));
    }
  }
}

TEST_P(N22, MeshesScaleByPowersOfTwoToTheBit) {
  Random random(22, seed());
  for (const TriangleMesh& mesh : {icosphere(2), triangle_soup(300, seed())}) {
    for (const int exponent : {-60, -20, -1, 3, 60}) {
      compare(
          mesh, scaled(mesh, exponent), random, ray_count(1'000'000 / kShards / 10),
          [=](const Ray& ray) { return scaled(ray, exponent); },
          [](const Hit& a, const Hit& b, const Ray& ray) { ASSERT_EQ(a, b) << describe(ray); });
    }
  }
}

void expect_close(const Hit& a, const Hit& b, const Ray& ray) {
  ASSERT_EQ(a.primitive, b.primitive) << describe(ray);
  ASSERT_NEAR(a.t, b.t, 4 * std::nextafter(a.t, HUGE_VAL) - 4 * a.t) << describe(ray);
}

TEST_P(N22, MirroredMeshesGiveTheSameBits) {
  Random random(122, seed());
  const TriangleMesh mesh = triangle_soup(300, seed());
  compare(
      mesh,
      changed(mesh,
              [](const Float3& p) {
                return Float3{-p.x, p.y, p.z};
              }),
      random, ray_count(1'000'000 / kShards),
      [](Ray ray) {
        ray.origin.x = -ray.origin.x, ray.direction.x = -ray.direction.x;
        return ray;
      },
      expect_close);
}

TEST_P(N22, TurnedAxesGiveTheSameHits) {
  Random random(222, seed());
  const TriangleMesh mesh = triangle_soup(300, seed());
  compare(
      mesh,
      changed(mesh,
              [](const Float3& p) {
                return Float3{p.y, p.z, p.x};
              }),
      random, ray_count(1'000'000 / kShards),
      [](const Ray& ray) {
        const auto& [o, d] = std::pair(ray.origin, ray.direction);
        return Ray{{o.y, o.z, o.x}, {d.y, d.z, d.x}};
      },
      expect_close);
}

TEST_P(N22, OrderOfTrianglesDecidesTiesAlone) {
  Random random(322, seed());
  const TriangleMesh mesh = triangle_soup(300, seed());
  TriangleMesh reversed = mesh;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  const auto last = static_cast<uint32_t>(mesh.triangles.size() - 1);
  compare(
      mesh, reversed, random, ray_count(1'000'000 / kShards), [](const Ray& ray) { return ray; },
      [last](const Hit& a, const Hit& b, const Ray& ray) {
        ASSERT_EQ(a.t, b.t) << describe(ray);
        ASSERT_EQ(a.primitive, last - b.primitive) << describe(ray);
      });
}

}  // namespace
}  // namespace tessera::numerics
