#include "renderer/math/elementary.h"

#include <gtest/gtest.h>
#include <quadmath.h>

#include <cmath>
#include <limits>
#include <random>

namespace tessera {
namespace {

using Quad = __float128;

/// Distance of `got` from the exact value in units of the last place of the nearest double.
double ulps(double got, Quad exact) {
  const double nearest = static_cast<double>(exact);
  if (got == nearest) return 0;
  const double ulp =
      std::max(std::abs(std::nextafter(nearest, std::numeric_limits<double>::infinity()) - nearest),
               std::numeric_limits<double>::denorm_min());
  return std::abs(static_cast<double>((static_cast<Quad>(got) - exact) / ulp));
}

template <typename Ours, typename Exact, typename Draw>
void expect_within_one_ulp(const char* name, Ours ours, Exact exact, Draw draw) {
  constexpr uint64_t kSeed = 7;
  std::mt19937_64 random(kSeed);
  double worst = 0, worst_at = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = draw(random);
    const double off = ulps(ours(x), exact(static_cast<Quad>(x)));
    if (off > worst) worst = off, worst_at = x;
  }
  EXPECT_LE(worst, 1.0) << name << " at " << std::hexfloat << worst_at << " seed " << kSeed;
}

auto uniform(double low, double high) {
  return [=](std::mt19937_64& r) { return std::uniform_real_distribution<>(low, high)(r); };
}
auto spread(double low_exponent, double high_exponent, bool both_signs) {
  return [=](std::mt19937_64& r) {
    const double x = std::exp2(std::uniform_real_distribution<>(low_exponent, high_exponent)(r));
    return both_signs && (r() & 1) ? -x : x;
  };
}

TEST(Elementary, TrigonometryIsWithinOneUlp) {
  for (const auto& draw : {uniform(-4, 4), uniform(-1e6, 1e6)}) {
    expect_within_one_ulp("sin", portable::sin, sinq, draw);
    expect_within_one_ulp("cos", portable::cos, cosq, draw);
    expect_within_one_ulp("tan", portable::tan, tanq, draw);
  }
  expect_within_one_ulp("sin", portable::sin, sinq, spread(-60, 19, true));
  expect_within_one_ulp("tan", portable::tan, tanq, spread(-60, 19, true));
  // Near multiples of pi/2 almost every bit of the argument cancels.
  const auto near_quarter = [](std::mt19937_64& r) {
    return static_cast<double>(static_cast<Quad>(r() % 600000) * acosq(0));
  };
  expect_within_one_ulp("sin", portable::sin, sinq, near_quarter);
  expect_within_one_ulp("cos", portable::cos, cosq, near_quarter);
  expect_within_one_ulp("tan", portable::tan, tanq, near_quarter);
}

TEST(Elementary, ArcsAreWithinOneUlp) {
  for (const auto& draw : {spread(-40, 0, true), spread(-2, 0, true)}) {
    expect_within_one_ulp("asin", portable::asin, asinq, draw);
    expect_within_one_ulp("acos", portable::acos, acosq, draw);
  }
  expect_within_one_ulp("acos", portable::acos, acosq, uniform(-1, 1));
  expect_within_one_ulp("atan", portable::atan, atanq, spread(-60, 60, true));
  expect_within_one_ulp("atan", portable::atan, atanq, uniform(-3, 3));
  std::mt19937_64 random(11);
  for (int i = 0; i < 20000; ++i) {
    const double y = spread(-300, 300, true)(random), x = y * spread(-20, 20, true)(random);
    EXPECT_LE(ulps(portable::atan2(y, x), atan2q(y, x)), 1.0) << std::hexfloat << y << " " << x;
  }
  // Of directions, both ways to work it out round but once.
  for (int i = 0; i < 100000; ++i) {
    const double y = uniform(-1, 1)(random);
    const double x = i % 4 == 0 ? y * (i % 33 - 16) / 16 : uniform(-1, 1)(random);
    EXPECT_LE(ulps(portable::atan2(y, x), atan2q(y, x)), 0.51) << std::hexfloat << y << " " << x;
  }
}

TEST(Elementary, ExponentialsAreWithinOneUlp) {
  expect_within_one_ulp("exp", portable::exp, expq, uniform(-2, 2));
  expect_within_one_ulp("exp", portable::exp, expq, uniform(-700, 700));
  expect_within_one_ulp("exp", portable::exp, expq, spread(-60, 2, true));
  expect_within_one_ulp("log", portable::log, logq, spread(-1000, 1000, false));
  expect_within_one_ulp("log", portable::log, logq, uniform(0.5, 2));
  const auto near_one = [](std::mt19937_64& r) { return 1 + spread(-50, -3, true)(r); };
  expect_within_one_ulp("log", portable::log, logq, near_one);
  std::mt19937_64 random(13);
  for (int i = 0; i < 20000; ++i) {
    const double x = spread(-40, 40, false)(random);
    const double y = uniform(-690, 690)(random) / std::log(x);
    EXPECT_LE(ulps(portable::pow(x, y), powq(x, y)), 1.0) << std::hexfloat << x << " " << y;
  }
}

TEST(Elementary, SpecialValues) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  using namespace portable;
  EXPECT_EQ(portable::sin(0.0), 0);
  EXPECT_EQ(portable::cos(0.0), 1);
  EXPECT_EQ(portable::exp(0.0), 1);
  EXPECT_EQ(portable::log(1.0), 0);
  EXPECT_EQ(portable::log(0.0), -kInf);
  EXPECT_EQ(portable::exp(-kInf), 0);
  EXPECT_EQ(portable::exp(kInf), kInf);
  EXPECT_EQ(portable::pow(0.0, 0.0), 1);
  EXPECT_EQ(portable::pow(0.0, 2.0), 0);
  EXPECT_EQ(portable::pow(3.0, 2.0), 9);
  EXPECT_EQ(portable::asin(1.0), kPi / 2);
  EXPECT_EQ(portable::acos(1.0), 0);
  EXPECT_EQ(portable::acos(-1.0), kPi);
  EXPECT_EQ(portable::atan2(0.0, -1.0), kPi);
  EXPECT_TRUE(std::signbit(portable::atan2(-0.0, 1.0)));
  EXPECT_EQ(portable::atan2(1.0, 0.0), kPi / 2);
  EXPECT_TRUE(std::isnan(portable::asin(1.5)));
  EXPECT_TRUE(std::isnan(portable::log(-1.0)));
  EXPECT_TRUE(std::isnan(portable::sin(kInf)));
}

}  // namespace
}  // namespace tessera
