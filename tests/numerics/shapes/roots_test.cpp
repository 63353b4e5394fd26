// N08, N09: polynomial roots against quad precision.
#include <gtest/gtest.h>

#include <vector>

#include "renderer/math/quadratic.h"
#include "renderer/math/quartic.h"
#include "tests/numerics/support.h"

namespace tessera::numerics {
namespace {

using N08 = Shard;
INSTANTIATE_TEST_SUITE_P(Seed, N08, kSeeds);

double ulp_of(double x) { return std::nextafter(std::abs(x), HUGE_VAL) - std::abs(x); }

void check_quadratic(double a, double b, double c) {
  double r[2];
  const int n = solve_quadratic(a, b, c, r);
  for (int i = 0; i < n; ++i) ASSERT_FALSE(std::isnan(r[i])) << a << " " << b << " " << c;
  if (a == 0) {
    ASSERT_EQ(n, b == 0 ? 0 : 1);
    if (n == 1) {
      ASSERT_EQ(r[0], 0 - c / b);
    }
    return;
  }
  // Exact: products of two doubles fit a quad's significand.
  const Quad bb = Quad(b) * b, ac = 4 * Quad(a) * c;
  if (bb < ac) {
    ASSERT_EQ(n, 0) << a << " " << b << " " << c;
    return;
  }
  ASSERT_GE(n, 1) << a << " " << b << " " << c;
  const Quad root = sqrtq(bb - ac);
  const Quad q = -(b < 0 ? b - root : b + root) / 2;
  Quad x0 = q == 0 ? 0 : q / a, x1 = q == 0 ? 0 : c / q;
  if (x0 > x1) std::swap(x0, x1);
  const auto near = [&](double x, Quad exact) {
    return fabsq(x - exact) <= 4 * Quad(ulp_of(static_cast<double>(exact)));
  };
  ASSERT_TRUE(near(r[0], x0)) << a << " " << b << " " << c;
  ASSERT_TRUE(near(r[n - 1], x1)) << a << " " << b << " " << c;
}

TEST(N09, QuadraticsHaveTheRightNumberOfRoots) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(9, seed);
    const auto number = [&] {
      return std::ldexp(random.next() & 1 ? random.uniform(1, 2) : -random.uniform(1, 2),
                        random.below(121) - 60);
    };
    for (int64_t i = 0; i < ray_count(1000000); ++i) {
      double a = number(), b = number(), c = number();
      check_quadratic(a, b, c);
      // Discriminant exactly 0: (2 k m x + l)^2 with few digits; then one ulp to either side.
      const double k = std::ldexp(1 + random.below(1 << 24), random.below(41) - 30);
      const double l = std::ldexp(1 + random.below(1 << 24), random.below(41) - 30);
      a = k * k, b = (random.next() & 1 ? 2 : -2) * k * l, c = l * l;
      check_quadratic(a, b, c);
      double r[2];
      ASSERT_EQ(solve_quadratic(a, b, c, r), 1);
      check_quadratic(a, b, std::nextafter(c, HUGE_VAL));
      check_quadratic(a, b, std::nextafter(c, -HUGE_VAL));
      check_quadratic(a, std::nextafter(b, HUGE_VAL), c);
      check_quadratic(a, std::nextafter(b, -HUGE_VAL), c);
      const double maybe[3] = {number(), 0, -0.0};
      check_quadratic(maybe[random.below(3)], maybe[random.below(3)], maybe[random.below(3)]);
    }
  }
}

std::vector<double> quartic(double a3, double a2, double a1, double a0) {
  std::array<double, 4> roots;
  const int n = solve_quartic({a0, a1, a2, a3, 1}, roots);
  return {roots.begin(), roots.begin() + n};
}

void expect_roots(const std::vector<double>& found, const std::vector<double>& expected,
                  double relative) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], expected[i], relative * std::abs(expected[i]));
}

TEST(N08, PublishedQuartics) {
  expect_roots(quartic(-240, 25449, -1325880, 26471900.25), {50.645112696960, 69.354887303040},
               1e-12);
  expect_roots(quartic(-198.995, 15006.6, -508127, 6520250), {}, 0);
  expect_roots(quartic(19.534611, -48660.891842, -476217.617178, 57126150.652217),
               {-223.009483226258, -39.885284685583, 30.117978814528, 213.242178097447}, 1e-12);
  expect_roots(quartic(560.321851, 63482.219234, -4204634.184030, -991844121.190186),
               {-384.010162149417, 103.849237300595}, 1e-12);
  expect_roots(quartic(-6, 13, -12, 4), {1, 2}, 1e-7);        // (x-1)^2 (x-2)^2
  expect_roots(quartic(-4, 6, -4, 1), {1}, 1e-3);             // (x-1)^4
  expect_roots(quartic(0, -5, 0, 4), {-2, -1, 1, 2}, 1e-15);  // biquadratics
  expect_roots(quartic(0, 5, 0, 4), {}, 0);
  expect_roots(quartic(0, -1, 0, 0), {-1, 0, 1}, 1e-15);
  expect_roots(quartic(0, 0, 0, 0), {0}, 0);
  // Roots 1, 1e3, 1e6, 1e9.
  expect_roots(quartic(-1001001001, 1001002001001e3, -1001001001e9, 1e18), {1, 1e3, 1e6, 1e9},
               1e-5);
}

/// |p(x)| over the sum of the magnitudes of its terms, in quad precision.
double backward_error(const Polynomial<4>& c, double x) {
  Quad value = 0, size = 0;
  for (int i = 4; i >= 0; --i) {
    value = value * x + c[i];
    size = size * fabsq(x) + fabsq(c[i]);
  }
  return size > 0 ? static_cast<double>(fabsq(value) / size) : 0;
}

/// The number of distinct real roots by Sturm's theorem, in quad precision.
int sturm_count(const Polynomial<4>& c) {
  std::vector<std::vector<Quad>> chain{{c[0], c[1], c[2], c[3], c[4]},
                                       {c[1], 2 * Quad(c[2]), 3 * Quad(c[3]), 4 * Quad(c[4])}};
  while (chain.back().size() > 1) {
    std::vector<Quad> rest = chain[chain.size() - 2];
    const std::vector<Quad>& by = chain.back();
    while (rest.size() >= by.size()) {
      const Quad factor = rest.back() / by.back();
      for (size_t i = 0; i < by.size(); ++i) rest[rest.size() - by.size() + i] -= factor * by[i];
      rest.pop_back();
    }
    for (Quad& q : rest) q = -q;
    chain.push_back(rest);
  }
  const auto changes = [&](bool at_minus) {
    int n = 0, last = 0;
    for (const auto& p : chain) {
      int sign = p.back() > 0 ? 1 : p.back() < 0 ? -1 : 0;
      if (at_minus && p.size() % 2 == 0) sign = -sign;
      if (sign != 0 && last != 0 && sign != last) ++n;
      if (sign != 0) last = sign;
    }
    return n;
  };
  return changes(true) - changes(false);
}

TEST_P(N08, RandomQuartics) {
  Random random(8, seed());
  for (int64_t i = 0; i < ray_count(1000000); ++i) {
    Polynomial<4> c{1, 0, 0, 0, 0};
    if (i % 2) {
      for (double& x : c) x = random.power(-4, 4);
    } else {
      // Roots and pairs of widely different sizes.
      for (int pair = 0; pair < 2; ++pair) {
        const double x = random.power(-3, 3);
        const double y = random.power(-3, 3);
        const double b = random.next() & 1 ? -(x + y) : random.power(-3, 3);
        const double q = random.next() & 1 ? x * y : random.power(-6, 6);
        const Polynomial<4> old = c;
        c = {};
        for (int k = 0; k <= 4; ++k) {
          c[k] += q * old[k];
          if (k >= 1) c[k] += b * old[k - 1];
          if (k >= 2) c[k] += old[k - 2];
        }
      }
      if (c[4] == 0) continue;
    }
    std::array<double, 4> roots;
    const int n = solve_quartic(c, roots);
    for (int k = 0; k < n; ++k) {
      ASSERT_FALSE(std::isnan(roots[k]));
      ASSERT_LE(backward_error(c, roots[k]), 64 * 0x1p-53) << "seed " << seed() << " at " << i;
      if (k > 0) {
        ASSERT_GT(roots[k], roots[k - 1]);
      }
    }
    const int expected = sturm_count(c);
    if (n == expected) continue;
    // Only where the roots in doubt are as good as double: the polynomial all but touches 0 at a
    // turning point.
    std::array<double, 3> turns;
    const Polynomial<3> slope = derivative<4>(c);
    const int turn_count = roots_between<3>(slope, -1e30, 1e30, turns);
    double nearest = 1;
    for (int k = 0; k < turn_count; ++k) nearest = std::min(nearest, backward_error(c, turns[k]));
    EXPECT_LE(nearest, 8 * 0x1p-53)
        << "seed " << seed() << " at " << i << ": " << n << " roots for " << expected;
  }
}

}  // namespace
}  // namespace tessera::numerics
