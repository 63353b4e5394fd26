#include "renderer/shapes/triangle_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/uniform_numbers.h"
#include "tests/unit/renderer/shapes/shining_meshes.h"

namespace tessera {
namespace {

struct Grown {
  std::vector<TriangleCorners> triangles;
  std::vector<double> areas;
  std::vector<uint32_t> order;

  explicit Grown(const TriangleMesh& mesh) {
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [a, b, c] = mesh.corners(i);
      const double area = length(cross(b - a, c - a)) / 2;
      if (area == 0) continue;
      triangles.push_back({a, b, c});
      areas.push_back(area);
    }
  }
  TriangleTree tree() { return {triangles, areas, order}; }
};

TEST(TriangleTree, PicksWithTheProbabilityThatItTells) {
  const Affine stretch = scaling({1, 3, 0.5});
  for (const TriangleMesh& mesh :
       {bumpy_sheet(1), bumpy_sheet(9), ball_mesh(3, 1), ball_mesh(7, 0.1)}) {
    Grown grown(mesh);
    const TriangleTree tree = grown.tree();
    std::vector<uint32_t> sorted = grown.order;
    std::ranges::sort(sorted);
    for (size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
    for (const Point3& from : {Point3{0.2, 0.1, 0.3}, Point3{1, -2, 2}, Point3{90, 20, 10}}) {
      for (const Affine* const measure : {static_cast<const Affine*>(nullptr), &stretch}) {
        const TriangleTree::View view{from, {0, 0.6, -0.8}, 1, measure, 2};
        constexpr int kSteps = 1 << 13;
        int parts = 0;
        double total = 0;
        for (size_t place = 0; place < grown.order.size(); ++parts) {
          const TriangleTree::Part part = tree.holding(view, place);
          ASSERT_EQ(part.from, place);
          double area = 0;
          for (; place < part.to; ++place) {
            area += grown.areas[grown.order[place]];
            const TriangleTree::Part same = tree.holding(view, place);
            ASSERT_EQ(same.from, part.from);
            ASSERT_EQ(same.probability, part.probability);
          }
          EXPECT_NEAR(part.area, area, 1e-12 * area);
          EXPECT_GT(part.probability, 0);
          // It is an interval of u, to within the ends of it.
          int found = 0;
          for (int i = 0; i < kSteps; ++i) {
            double u = (i + 0.5) / kSteps;
            const TriangleTree::Part picked = tree.pick(view, u);
            ASSERT_TRUE(u >= 0 && u < 1);
            if (picked.from != part.from) continue;
            ++found;
            ASSERT_EQ(picked.to, part.to);
            ASSERT_EQ(picked.probability, part.probability);
            ASSERT_EQ(picked.area, part.area);
          }
          EXPECT_NEAR(found, part.probability * kSteps, 1.01);
          total += part.probability;
        }
        EXPECT_NEAR(total, 1, 1e-12);
        if (grown.order.size() > 20 && from.x < 10) {
          EXPECT_GT(parts, 10);
        }
      }
    }
  }
}

TEST(TriangleTree, HasAFifthOfTheVarianceByArea) {
  const Vec3 normal = normalize(Vec3{0.3, 0.2, -0.9});
  for (const TriangleMesh& mesh :
       {ring_mesh(40, 14, 0.4), ring_mesh(400, 16, 0.05), ball_mesh(12, 1), bumpy_sheet(12)}) {
    Grown grown(mesh);
    const TriangleTree tree = grown.tree();
    UniformNumbers random(5);
    double by_tree = 0, by_area = 0;
    for (int view = 0; view < 20; ++view) {
      const Point3 from{random.between(-2, 2), random.between(-2, 2), random.between(1, 2)};
      double light = 0, of_tree = 0, of_area = 0, all = 0;
      for (const double area : grown.areas) all += area;
      for (size_t place = 0; place < grown.order.size(); ++place) {
        const auto& [a, b, c] = grown.triangles[grown.order[place]];
        const double area = grown.areas[grown.order[place]];
        const Vec3 way = a + ((b - a) + (c - a)) / 3 - from;
        const double facing = -dot(way, normalize(cross(b - a, c - a))), lit = dot(way, normal);
        if (facing <= 0 || lit <= 0) continue;
        const double brought = area * facing * lit / std::pow(length_squared(way), 2);
        const auto part = tree.holding({.from = from, .normal = normal, .side = 1}, place);
        light += brought;
        of_tree += brought * brought * part.area / (part.probability * area);
        of_area += brought * brought * all / area;
      }
      if (light == 0) continue;
      by_tree += of_tree / (light * light) - 1;
      by_area += of_area / (light * light) - 1;
    }
    EXPECT_LT(by_tree, 0.2 * by_area);
  }
}

TEST(TriangleTree, LeavesWhatIsFarAndFlatWhole) {
  TriangleMesh mesh = bumpy_sheet(8);
  for (Float3& p : mesh.positions) p.z *= 0.05f;
  Grown flat(mesh), round(ball_mesh(8, 1));
  const Vec3 normal{0, 0, -1};
  const auto count = [&](Grown& grown, const Point3& from) {
    const TriangleTree tree = grown.tree();
    size_t parts = 0;
    for (size_t at = 0; at < grown.order.size(); ++parts) {
      const size_t to = tree.holding({.from = from, .normal = normal}, at).to;
      if (to <= at) return size_t{0};
      at = to;
    }
    return parts;
  };
  EXPECT_EQ(count(flat, {0, 0, 50}), 1u);
  EXPECT_GT(count(flat, {0, 0, 0.1}), 30u);
  // All round, until what is left is about flat.
  EXPECT_GT(count(round, {0, 0, 50}), 20u);
}

}  // namespace
}  // namespace tessera
