// N04: triangles as thin as rounding allows, against exact arithmetic.
#include <array>

#include "renderer/shapes/triangle.h"
#include "tests/numerics/accelerators.h"
#include "tests/numerics/exact.h"

namespace tessera::numerics {
namespace {

using Corners = std::array<Point3, 3>;

/// On which side of the edge from a to b the ray passes, and how far.
struct Side {
  int sign = 0;
  Quad distance = 0;
};

Side side_of(const Ray& ray, const Point3& a, const Point3& b) {
  const QuadVec o(ray.origin), d(ray.direction);
  const QuadVec p = QuadVec(a) - o, q = QuadVec(b) - o, n = cross(p, q);
  const Quad volume = dot(d, n);
  Side side{volume > 0 ? 1 : volume < 0 ? -1 : 0, fabsq(volume) / length(cross(d, q - p))};
  if (fabsq(volume) > 0x1p-100 * length(d) * length(p) * length(q)) return side;
  std::array<Exact, 3> pe, qe;
  for (int k = 0; k < 3; ++k) {
    pe[size_t(k)] = Exact(a[k]) - Exact(ray.origin[k]);
    qe[size_t(k)] = Exact(b[k]) - Exact(ray.origin[k]);
  }
  Exact exact;
  for (size_t k = 0; k < 3; ++k) {
    const size_t i = (k + 1) % 3, j = (k + 2) % 3;
    exact = exact + Exact(ray.direction[int(k)]) * (pe[i] * qe[j] - pe[j] * qe[i]);
  }
  side.sign = exact.sign();
  return side;
}

/// Whether the line meets the triangle, by exact signs; how near it passes to an edge.
struct Crossing {
  bool inside = false;
  double nearest_edge = 0;
};

Crossing crossing_of(const Ray& ray, const Corners& c) {
  const Side s[3] = {side_of(ray, c[0], c[1]), side_of(ray, c[1], c[2]), side_of(ray, c[2], c[0])};
  return {s[0].sign != 0 && s[0].sign == s[1].sign && s[1].sign == s[2].sign,
          static_cast<double>(std::min(s[0].distance, std::min(s[1].distance, s[2].distance)))};
}

double farthest(const Ray& ray, const Corners& c) {
  return std::max(
      {distance(ray.origin, c[0]), distance(ray.origin, c[1]), distance(ray.origin, c[2])});
}

/// Whether the ray starts beside the triangle, not before it, and sees it so thin that it could as
/// well have left it: such a triangle is not hit, lest surfaces shade themselves. PBRT's bound on t
/// comes to about 128 u of the triangle's depth, over its width as seen.
bool may_be_given_up(const Ray& ray, const Corners& c, double nearest_edge) {
  const Vec3 d = normalize(ray.direction);
  const double far = farthest(ray, c), slack = 0x1p-29 * far;
  const QuadVec n = cross(QuadVec(c[1]) - QuadVec(c[0]), QuadVec(c[2]) - QuadVec(c[0]));
  const Quad ahead = dot(n, QuadVec(c[0]) - QuadVec(ray.origin)) / dot(n, QuadVec(d));
  if (nearest_edge * static_cast<double>(ahead) > 128 * kUnitRoundoff * far * far) return false;
  const Vec3 size = abs(d);
  const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
  const double side = d[axis] < 0 ? -1 : 1;
  double nearest = far;
  for (const Point3& p : c) nearest = std::min(nearest, side * (p[axis] - ray.origin[axis]));
  return nearest <= slack;
}

/// Inside, near an edge, or a little outside.
Point3 target_in(const Corners& c, Random& random) {
  double u = random.uniform(), v = random.uniform();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  switch (random.below(4)) {
    case 0:
      u = random.power(-18, -1);
      break;
    case 1:
      v = 1 - u + random.power(-18, -1);
      break;
    default:
      break;
  }
  return c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v;
}

/// From any direction, or nearly in the plane of the triangle.
Ray aimed(const Corners& c, Random& random) {
  const Point3 target = target_in(c, random);
  Vec3 back = random.direction();
  const Vec3 n = cross(c[1] - c[0], c[2] - c[0]);
  if (random.below(3) == 0 && length(n) > 0)
    back = across(normalize(n), random) + normalize(n) * random.power(-14, -1);
  const Point3 origin = target + back * std::pow(10, random.uniform(-1, 3));
  return {origin, (target - origin) * std::abs(random.power(-2, 2))};
}

using N04 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N04, kSeeds);

TEST_P(N04, SliversAreHitWhereExactArithmeticSaysSo) {
  Random random(4, seed());
  int64_t hits = 0, misses = 0, in_band = 0, given_up = 0;
  for (int64_t i = 0; i < ray_count(10'000'000 / kShards); ++i) {
    const double height = std::pow(10, random.uniform(-12, -1));
    const Affine turn = random.turn();
    const Corners c{turn(Point3{0, 0, 0}), turn(Point3{1, 0, 0}),
                    turn(Point3{random.uniform(-0.5, 1.5), height, 0})};
    const Ray ray = aimed(c, random);
    const Crossing truth = crossing_of(ray, c);
    TriangleHit hit;
    const bool found = intersect_triangle(TriangleRay(ray), c[0], c[1], c[2], hit);
    const double u = kUnitRoundoff * farthest(ray, c);
    // Each sheared coordinate is off by up to 5 u.
    if (truth.nearest_edge <= 8 * u) {
      ++in_band;
    } else if (!found && truth.inside && may_be_given_up(ray, c, truth.nearest_edge)) {
      ++given_up;
    } else {
      ASSERT_EQ(found, truth.inside)
          << "seed " << seed() << " at " << i << " height " << height << ": " << describe(ray)
          << " edge " << truth.nearest_edge / u << " u";
      (found ? hits : misses)++;
    }
    if (!found) continue;
    // Seen edge-on its t is badly known, but never far from the triangle.
    const Point3 at = ray.at(hit.t);
    const double slack = 0x1p-29 * distance(ray.origin, at);
    for (int a = 0; a < 3; ++a) {
      ASSERT_GE(at[a], std::min({c[0][a], c[1][a], c[2][a]}) - slack) << "at " << i;
      ASSERT_LE(at[a], std::max({c[0][a], c[1][a], c[2][a]}) + slack) << "at " << i;
    }
  }
  EXPECT_GT(hits, ray_count(4'000'000 / kShards));
  EXPECT_GT(misses, ray_count(400'000 / kShards));
  EXPECT_LT(given_up, hits / 100);
  RecordProperty("in_band", std::to_string(in_band));
}

/// A thousand triangles about one vertex that together cover `angle`.
TriangleMesh fan(double angle, const Affine& place) {
  TriangleMesh mesh;
  const auto add = [&](const Point3& p) {
    const Point3 q = place(p);
    mesh.positions.push_back(
        {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
  };
  add({});
  for (uint32_t i = 0; i <= 1000; ++i) {
    const double turn = angle * i / 1000;
    add({std::cos(turn), std::sin(turn), 0.01 * (i % 7)});
    if (i > 0) mesh.triangles.push_back({0, i, i + 1});
  }
  drop_degenerate(mesh);
  return mesh;
}

TEST_P(N04, FansOfSliversHaveNoSlits) {
  int64_t tested = 0;
  for (const double angle : {6.28, 0.1, 1e-3}) {
    Random random(104, seed());
    const auto mesh = std::make_shared<const TriangleMesh>(fan(
        angle, translation(random.direction() * std::abs(random.power(-2, 0))) * random.turn()));
    const Accelerators all = Accelerators::over(mesh);
    for (int64_t i = 0; i < ray_count(1'000'000 / kShards / 3); ++i) {
      // Well inside of the fan: it is met, whatever single triangles say.
      const auto c = mesh->corners(100 + random.below(mesh->triangles.size() - 200));
      const double from_tip = random.below(2) ? 0.5 : std::abs(random.power(-3, -0.3));
      const Point3 target =
          c[0] + (c[1] - c[0]) * (from_tip * random.uniform()) + (c[2] - c[0]) * (0.4 * from_tip);
      const Point3 origin = target + random.direction() * std::abs(random.power(-1, 2));
      const Ray ray{origin, target - origin};
      ASSERT_EQ(disagreements(all, ray), 0) << "seed " << seed() << " " << describe(ray);
      if (!crossing_of(ray, c).inside) continue;
      ++tested;
      Hit hit;
      TraversalCounters counters;
      ASSERT_TRUE(all.all[0]->closest_hit(ray, hit, counters)) << describe(ray);
    }
  }
  EXPECT_GT(tested, ray_count(10'000));
}

}  // namespace
}  // namespace tessera::numerics
