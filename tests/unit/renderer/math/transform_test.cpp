#include "renderer/math/transform.h"

#include <gtest/gtest.h>

#include <random>

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

Transform random_transform(std::mt19937_64& random) {
  std::uniform_real_distribution<> d(-3, 3);
  Affine a;
  do {
    for (auto& row : a.m)
      for (double& entry : row) entry = d(random);
  } while (std::abs(a.determinant()) < 0.1);
  return Transform(a);
}

TEST(Transform, IdentityIsExact) {
  EXPECT_EQ(inverse(Affine{}), Affine{});
  EXPECT_EQ(Transform{}.point(Point3{1, 2, 3}), (Point3{1, 2, 3}));
}

TEST(Transform, InversesOfTheHugeAndTheTinyAreExact) {
  for (const double size : {0x1p400, 0x1p-400, 0x1p1000, 0x1p-1000}) {
    const Affine large = scaling({size, size, 2 * size});
    ASSERT_TRUE(is_invertible(large)) << size;
    EXPECT_EQ(inverse(large), scaling({1 / size, 1 / size, 0.5 / size}));
  }
  const Affine unlike = scaling({0x1p600, 0x1p-600, 1});
  EXPECT_FALSE(is_invertible(scaling({0x1p600, 0, 1})));
  EXPECT_EQ(inverse(unlike), scaling({0x1p-600, 0x1p600, 1}));
}

TEST(Transform, InverseUndoesWithinItsErrorBound) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<> d(-10, 10);
  for (int i = 0; i < 1000; ++i) {
    const Transform t = random_transform(random);
    const Point3 p{d(random), d(random), d(random)};
    EXPECT_LT(distance(t.inverse_point(t.point(p)), p), 1e-11);
  }
}

TEST(Transform, PointErrorBoundsTheRounding) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<> d(-10, 10);
  for (int i = 0; i < 2000; ++i) {
    const Transform t = random_transform(random);
    const Point3 p{d(random), d(random), d(random)};
    const Point3 q = t.point(p);
    const Vec3 bound = t.point_error(p, {});
    for (int r = 0; r < 3; ++r) {
      const auto& m = t.matrix().m[r];
      const __float128 exact = static_cast<__float128>(m[0]) * p.x +
                               static_cast<__float128>(m[1]) * p.y +
                               static_cast<__float128>(m[2]) * p.z + m[3];
      EXPECT_LE(std::abs(static_cast<double>(exact - q[r])), bound[r]);
    }
  }
}

TEST(Transform, NormalsStayPerpendicular) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100; ++i) {
    const Transform t = random_transform(random);
    const Vec3 tangent{1, 2, -1};
    const Normal3 n{3, -1, 1};
    ASSERT_EQ(dot(n, tangent), 0);
    EXPECT_NEAR(dot(t.normal(n), t.vector(tangent)), 0, 1e-11);
  }
}

TEST(Transform, BoundsHoldEveryMappedPoint) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<> d(-1, 1);
  const Bounds3 box{{-1, -1, -1}, {1, 1, 1}};
  for (int i = 0; i < 1000; ++i) {
    const Transform t = random_transform(random);
    EXPECT_TRUE(t.bounds(box).contains(t.point(Point3{d(random), d(random), d(random)})));
  }
  const double inf = Bounds3::kInfinity;
  const Bounds3 all =
      Transform(rotation({1, 2, 3}, 1)).bounds({{-inf, -inf, -inf}, {inf, inf, inf}});
  EXPECT_EQ(all.min.x, -inf);
  EXPECT_EQ(all.max.z, inf);
}

TEST(Transform, LookAtFacesItsTarget) {
  const Affine a = look_at({1, 2, 3}, {1, 2, -5}, {0, 1, 0});
  EXPECT_EQ(a(Vec3{0, 0, -1}), (Vec3{0, 0, -1}));
  EXPECT_EQ(a(Vec3{0, 1, 0}), (Vec3{0, 1, 0}));
  EXPECT_EQ(a(Point3{}), (Point3{1, 2, 3}));
  const Affine up = look_at({0, 0, 0}, {0, 4, 0}, {0, 1, 0});
  EXPECT_EQ(up(Vec3{0, 0, -1}), (Vec3{0, 1, 0}));
  EXPECT_GT(up.determinant(), 0.999);
}

TEST(Transform, RotationTurnsRightHanded) {
  const Vec3 v = rotation({0, 0, 2}, portable::kPi / 2)(Vec3{1, 0, 0});
  EXPECT_NEAR(v.x, 0, 1e-16);
  EXPECT_EQ(v.y, 1);
}

}  // namespace
}  // namespace tessera
