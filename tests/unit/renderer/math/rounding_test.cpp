#include "renderer/math/rounding.h"

#include <gtest/gtest.h>
#include <quadmath.h>

#include <random>

namespace tessera {
namespace {

TEST(Rounding, NeighboursAreThoseOfTheLibrary) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double x : {0.0, -0.0, 1.0, -1.0, 1e-310, -1e-310, 1e308, -kInf}) {
    EXPECT_EQ(next_up(x), std::nextafter(x, kInf)) << x;
    EXPECT_EQ(next_down(-x), std::nextafter(-x, -kInf)) << x;
  }
  EXPECT_EQ(next_up(kInf), kInf);
}

TEST(Rounding, ConversionToFloatGoesOutward) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 10000; ++i) {
    const double x = std::ldexp(static_cast<double>(static_cast<int64_t>(random())),
                                static_cast<int>(random() % 200) - 160);
    EXPECT_LE(float_down(x), x);
    EXPECT_GE(float_up(x), x);
    EXPECT_LE(float_up(x), std::nextafter(float_down(x), INFINITY));
  }
  EXPECT_EQ(float_down(0.5), 0.5f);
  EXPECT_EQ(float_up(1e300), INFINITY);
}

TEST(Rounding, DifferenceOfProductsHasTheRightSignAndTwoUlp) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<> unit(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const double a = unit(random), b = unit(random), c = unit(random);
    // d makes the two products almost equal.
    const double d = std::nextafter(a * b / c, i % 2 ? 1e9 : -1e9);
    const __float128 exact = static_cast<__float128>(a) * b - static_cast<__float128>(c) * d;
    const double got = difference_of_products(a, b, c, d);
    const double nearest = static_cast<double>(exact);
    EXPECT_LE(std::abs(got - nearest), 2 * 0x1p-52 * std::abs(nearest));
    EXPECT_EQ(got < 0, exact < 0);
  }
}

}  // namespace
}  // namespace tessera
