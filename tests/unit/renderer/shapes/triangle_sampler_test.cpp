#include "renderer/shapes/triangle_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "renderer/math/rounding.h"
#include "tests/chi_square.h"
#include "tests/uniform_numbers.h"
#include "tests/unit/renderer/shapes/shining_meshes.h"

namespace tessera {
namespace {

struct Placed {
  std::string name;
  TriangleMesh mesh;
  Affine to_world;
};

/// One huge triangle and many tiny ones above its middle.
TriangleMesh crumbs() {
  TriangleMesh mesh = bumpy_sheet(6);
  for (Float3& p : mesh.positions) p = {p.x * 1e-3f, p.y * 1e-3f, p.z * 1e-3f + 0.3f};
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const Float3& p : {Float3{-4, -4, 0}, Float3{4, -4, 0}, Float3{0, 6, 0}})
    mesh.positions.push_back(p);
  mesh.triangles.push_back({first, first + 1, first + 2});
  return mesh;
}

std::vector<Placed> placed_meshes() {
  const Affine turned = translation({0.3, 0.1, -0.2}) * rotation({1, 2, 3}, 0.7);
  Affine sheared;
  sheared.m[0][1] = 0.7, sheared.m[1][2] = -0.4;
  std::vector<Placed> all;
  const auto add = [&](const std::string& name, const TriangleMesh& mesh) {
    all.push_back({name, mesh, {}});
    all.push_back({name + " of another size", mesh, turned * scaling({2, 2, 2})});
    all.push_back({name + " mirrored", mesh, turned * scaling({-1, 1, 1})});
    all.push_back({name + " stretched", mesh, turned * scaling({0.5, 3, -1})});
    all.push_back({name + " sheared", mesh, turned * sheared});
  };
  add("sheet", bumpy_sheet(7));
  add("ball", ball_mesh(6, 1));
  add("crumbs", crumbs());
  return all;
}
const Point3 kPlaces[] = {
    {0.2, 0.1, 0.6}, {0.03, 0.01, 0.07}, {0.4, -0.3, -0.5}, {1.2, 3, 2}, {300, 100, 5}};
const Vec3 kNormal = normalize(Vec3{-1, -2, 0.5});

std::unique_ptr<const SurfaceSampler> sampler_of(const Placed& placed,
                                                 LitSides sides = LitSides::both,
                                                 bool flip = false) {
  return make_triangle_sampler(std::make_shared<TriangleSet>(TriangleSet::of(placed.mesh, 0)),
                               Transform(placed.to_world), flip, sides);
}
TriangleCorners corners_of(const Placed& placed, size_t triangle) {
  const auto [a, b, c] = placed.mesh.corners(triangle);
  return {placed.to_world(a), placed.to_world(b), placed.to_world(c)};
}
/// The probability of each triangle, by the density that is told of its middle: that times the
/// cosine over the square of the distance is even on all of it.
std::vector<double> told_shares(const Placed& placed, const SurfaceSampler& sampler,
                                const LitPoint& from) {
  std::vector<double> shares;
  for (uint32_t i = 0; i < placed.mesh.triangles.size(); ++i) {
    const auto [a, b, c] = corners_of(placed, i);
    const Vec3 across = cross(b - a, c - a);
    if (length(across) == 0) {
      shares.push_back(0);
      continue;
    }
    const Point3 middle = a + ((b - a) + (c - a)) / 3;
    const Vec3 normal = normalize(across), way = middle - from.at;
    const double density = sampler.density(from, middle, normal, i);
    shares.push_back(density * std::abs(dot(way, normal)) / std::pow(length(way), 3) *
                     length(across) / 2);
  }
  return shares;
}
/// The triangle that holds a point of the surface.
size_t triangle_at(const Placed& placed, const Point3& point) {
  size_t best = 0;
  double least = 1e300;
  for (size_t i = 0; i < placed.mesh.triangles.size(); ++i) {
    const auto [a, b, c] = corners_of(placed, i);
    const Vec3 across = cross(b - a, c - a);
    if (length_squared(across) == 0) continue;
    const double v = dot(cross(point - a, c - a), across) / length_squared(across);
    const double w = dot(cross(b - a, point - a), across) / length_squared(across);
    const double out = std::max({0.0, -v, -w, v + w - 1}) * std::sqrt(length(across));
    const double off = std::abs(dot(point - a, across)) / length(across) + out;
    if (off < least) least = off, best = i;
  }
  return best;
}

TEST(TriangleSampler, SharesThatAreToldAddUpToOne) {
  for (const Placed& placed : placed_meshes()) {
    for (const LitSides sides : {LitSides::both, LitSides::front, LitSides::back}) {
      const auto sampler = sampler_of(placed, sides);
      for (const Point3& at : kPlaces) {
        double total = 0;
        for (const double share : told_shares(placed, *sampler, {at, kNormal})) total += share;
        EXPECT_NEAR(total, 1, 1e-9) << placed.name << " from " << at.x;
      }
    }
  }
}

TEST(TriangleSampler, ChoosesTrianglesByTheSharesThatItTells) {  // N28
  for (const Placed& placed : placed_meshes()) {
    const auto sampler = sampler_of(placed, LitSides::front);
    for (const Point3& at : kPlaces) {
      SCOPED_TRACE(placed.name + " from " + std::to_string(at.x));
      const LitPoint from{at, kNormal};
      constexpr int kCount = 4000;
      std::vector<double> expected = told_shares(placed, *sampler, from), found(expected.size());
      for (double& count : expected) count *= kCount;
      UniformNumbers random(3);
      for (int i = 0; i < kCount; ++i) {
        const double x = random(), y = random();
        SurfaceSample sample;
        const double density = sampler->sample(from, {x, y}, sample);
        ASSERT_GT(density, 0);
        const size_t triangle = triangle_at(placed, sample.point);
        const double told =
            sampler->density(from, sample.point, sample.normal, static_cast<uint32_t>(triangle));
        ASSERT_NEAR(told, density, 1e-6 * density);
        ++found[triangle];
      }
      EXPECT_LT(chi_square_sigmas(found, expected, std::vector<double>(found.size())),
                kChiSquareAlarm);
    }
  }
}

TEST(TriangleSampler, PrefersWhatIsNearAndTurnedThere) {
  const Placed sheet{"sheet", bumpy_sheet(16), {}};
  const auto sampler = sampler_of(sheet);
  const Point3 near{-0.8, -0.8, 0.5}, far{100, 100, 100};
  const Vec3 down{0, 0, -1}, up{0, 0, 1};
  const auto near_share = [&](const Point3& at, const Vec3& normal) {
    const std::vector<double> shares = told_shares(sheet, *sampler, {at, normal});
    double sum = 0;
    for (size_t i = 0; i < shares.size(); ++i) {
      const Point3 a = corners_of(sheet, i)[0];
      if (a.x < 0 && a.y < 0) sum += shares[i];
    }
    return sum;
  };
  EXPECT_GT(near_share(near, down), 0.6);  // by area it is .25
  EXPECT_NEAR(near_share(far, down), 0.25, 0.02);
  // Where all of it is behind, distance still counts.
  EXPECT_GT(near_share(near, up), 0.4);
  // A wall between: what it faces.
  const Point3 middle{0, 0, 0.3};
  EXPECT_GT(near_share(middle, normalize(Vec3{-1, -1, 0})), 0.5);
  EXPECT_LT(near_share(middle, normalize(Vec3{1, 1, 0})), 0.1);
}

TEST(TriangleSampler, PrefersTheSidesThatShine) {
  const Affine turned = rotation({1, 2, 3}, 0.7);
  for (const Affine& to_world :
       {Affine{}, turned, turned * scaling({-1, 1, 1}), turned * scaling({-1.2, 1, 0.9})}) {
    for (const bool flip : {false, true}) {
      const Placed ball{"ball", ball_mesh(12, 1), to_world};
      const Point3 at{1.5, 2, 1};
      const Vec3 normal = normalize(Point3{} - at);
      // How often the side that emits is the one that is seen.
      const auto seen = [&](LitSides sides) {
        const auto sampler = sampler_of(ball, sides, flip);
        constexpr int kCount = 2000;
        int count = 0;
        UniformNumbers random(5);
        for (int i = 0; i < kCount; ++i) {
          const double x = random(), y = random();
          SurfaceSample sample;
          EXPECT_GT(sampler->sample({at, normal}, {x, y}, sample), 0);
          const bool is_front = dot(at - sample.point, sample.normal) > 0;
          count += is_front == (sides == LitSides::front);
        }
        return static_cast<double>(count) / kCount;
      };
      // By area it would be about .3 and .7.
      EXPECT_GT(seen(flip ? LitSides::back : LitSides::front), 0.72) << flip;
      EXPECT_GT(seen(flip ? LitSides::front : LitSides::back), 0.72) << flip;
    }
  }
}

TEST(TriangleSampler, KnowsTrianglesByTheirNumbersInTheMesh) {
  Placed placed{"sheet", bumpy_sheet(6), {}};
  TriangleMesh& mesh = placed.mesh;
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    mesh.face_materials.push_back(i % 3 == 0 ? 1 : 0);
  mesh.triangles[4][1] = mesh.triangles[4][0];  // has no area
  const Point3 at{0.3, 0.4, 0.7};
  const auto sampler = sampler_of(placed);
  const std::vector<double> shares = told_shares(placed, *sampler, {at, kNormal});
  double total = 0;
  for (size_t i = 0; i < shares.size(); ++i) {
    EXPECT_EQ(shares[i] > 0, i % 3 != 0 && i != 4) << i;
    total += shares[i];
  }
  EXPECT_NEAR(total, 1, 1e-12);
  EXPECT_EQ(sampler->density({at, kNormal}, {0, 0, 0}, {0, 0, 1}, 1'000'000), 0);
}

TEST(TriangleSampler, LeavesPlanesEdgeOnAlone) {
  TriangleMesh mesh = bumpy_sheet(4);
  for (Float3& p : mesh.positions) p.z = 0;
  const Placed flat{"flat", mesh, {}};
  const auto sampler = sampler_of(flat);
  for (const Point3& at : {Point3{0.1, 0.2, 0}, Point3{5, 1, 0}}) {
    for (uint32_t i = 0; i < 50; ++i) {
      SurfaceSample sample;
      const double u = (i + 0.5) / 50;
      EXPECT_EQ(sampler->sample({at, kNormal}, {u, 0.3}, sample), 0);
      EXPECT_EQ(sampler->density({at, kNormal}, {0.5, 0.5, 0}, {0, 0, 1}, i % 32), 0);
    }
  }
}

TEST(TriangleSampler, LivesWithExtremes) {
  for (const double scale : {1e-150, 1e-100, 1e-30, 1e30, 1e100, 1e150}) {
    for (const Vec3& by : {Vec3{scale, scale, scale}, Vec3{scale, 1, -scale}}) {
      const auto sampler = sampler_of({"ball", ball_mesh(5, 1), scaling(by)});
      for (const Point3& at : {Point3{0, 0, 0}, Point3{1, 2, 3}, Point3{scale, 2 * scale, scale},
                               Point3{1e150, 0, 1e-150}}) {
        for (int i = 0; i < 40; ++i) {
          SurfaceSample sample;
          const double density = sampler->sample({at, kNormal}, {(i + 0.5) / 40, 0.4}, sample);
          EXPECT_TRUE(density >= 0 && std::isfinite(density)) << scale << " " << at.x;
          const double told =
              sampler->density({at, kNormal}, sample.point, {0, 0, 1}, static_cast<uint32_t>(i));
          EXPECT_TRUE(told >= 0 && std::isfinite(told)) << scale << " " << at.x;
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera
