#include "scenes/mesh/triangulate.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace tessera {
namespace {

double area_of(const std::vector<Vec3>& p, const std::vector<CornerTriple>& triples) {
  double sum = 0;
  for (const auto& [a, b, c] : triples) sum += length(cross(p[b] - p[a], p[c] - p[a])) / 2;
  return sum;
}

TEST(Triangulate, CutsAConvexPolygonIntoAFan) {
  const std::vector<Vec3> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<CornerTriple> triples;
  ASSERT_TRUE(triangulate(square, triples));
  EXPECT_EQ(triples, (std::vector<CornerTriple>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Triangulate, KeepsTheNotchOfAnArrowheadOpen) {
  // A fan about the first corner would cover the notch and have twice the area.
  const std::vector<Vec3> arrow{{0, 0, 5}, {2, -1, 5}, {0.5, 0, 5}, {2, 1, 5}};
  const std::vector<Vec3> turned{arrow[1], arrow[2], arrow[3], arrow[0]};
  for (const auto& polygon : {arrow, turned}) {
    std::vector<CornerTriple> triples;
    ASSERT_TRUE(triangulate(polygon, triples));
    ASSERT_EQ(triples.size(), 2u);
    EXPECT_NEAR(area_of(polygon, triples), 0.5, 1e-12);
  }
}

TEST(Triangulate, RefusesAConcavePolygonBeyondTheLimit) {
  std::vector<Vec3> star;
  for (size_t i = 0; i <= kMaxConcaveCorners; ++i) {
    const double angle = 6.283185307 * static_cast<double>(i) / (kMaxConcaveCorners + 1);
    const double radius = i % 2 ? 1 : 0.5;
    star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  std::vector<CornerTriple> triples;
  EXPECT_FALSE(triangulate(star, triples));
  EXPECT_TRUE(triples.empty());
}

RC_GTEST_PROP(Triangulate, CoversAnyStarShapedPolygonOnce, ()) {
  // Corners at increasing angles about the origin never cross; their area has a closed form.
  const auto radii = *rc::gen::resize(
      40, rc::gen::suchThat(rc::gen::container<std::vector<int>>(rc::gen::inRange(1, 100)),
                            [](const auto& r) { return r.size() >= 3; }));
  std::vector<Vec3> polygon;
  const auto n = static_cast<double>(radii.size());
  for (size_t i = 0; i < radii.size(); ++i) {
    const double angle = 2 * 3.14159265358979 * static_cast<double>(i) / n;
    polygon.push_back({radii[i] * std::cos(angle), 0, -radii[i] * std::sin(angle)});
  }
  double expected = 0;
  for (size_t i = 0; i < radii.size(); ++i)
    expected += radii[i] * radii[(i + 1) % radii.size()] * std::sin(2 * 3.14159265358979 / n) / 2;
  std::vector<CornerTriple> triples;
  RC_ASSERT(triangulate(polygon, triples));
  RC_ASSERT(triples.size() == radii.size() - 2);
  RC_ASSERT(std::abs(area_of(polygon, triples) - expected) <= 1e-9 * expected);
}

}  // namespace
}  // namespace tessera
