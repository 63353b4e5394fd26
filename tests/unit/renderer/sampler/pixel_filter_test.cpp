#include "renderer/sampler/pixel_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderer/sampler/sampler.h"

namespace tessera {
namespace {

struct Case {
  PixelFilter filter;
  double radius;
};

const std::vector<Case> kCases{{PixelFilter::gaussian, 1.5},
                               {PixelFilter::gaussian, 4},
                               {PixelFilter::mitchell, 2},
                               {PixelFilter::mitchell, 1.3},
                               {PixelFilter::blackman_harris, 2}};

/// The integral over [from, to] of `f`, by Simpson's rule.
template <typename Function>
double integral(double from, double to, const Function& f) {
  constexpr int kSteps = 4000;
  const double h = (to - from) / kSteps;
  double sum = f(from) + f(to);
  for (int i = 1; i < kSteps; ++i) sum += (i % 2 == 0 ? 2 : 4) * f(from + i * h);
  return sum * h / 3;
}

double size_of(const Case& c, double x) { return std::abs(filter_value(c.filter, c.radius, x)); }

TEST(PixelFilter, inverts_its_distribution) {
  for (const Case& c : kCases) {
    const FilterTable table(c.filter, c.radius);
    const auto size = [&](double x) { return size_of(c, x); };
    const double whole = integral(-c.radius, c.radius, size);
    double last = -c.radius - 1;
    for (int i = 0; i < 500; ++i) {
      const double u = i / 500.0;
      const FilterTable::Draw draw = table.draw(u);
      EXPECT_GT(draw.offset, last);
      last = draw.offset;
      EXPECT_NEAR(integral(-c.radius, draw.offset, size) / whole, u, 5e-6) << c.radius << " " << u;
      const double value = filter_value(c.filter, c.radius, draw.offset);
      if (std::abs(value) > 1e-4) {
        EXPECT_EQ(draw.negative, value < 0) << draw.offset;
      }
    }
    EXPECT_LT(table.draw(1 - 0x1p-32).offset, c.radius);
  }
}

TEST(PixelFilter, has_the_moments_of_its_function) {
  for (const Case& c : kCases) {
    const FilterTable table(c.filter, c.radius);
    const auto value = [&](double x) { return filter_value(c.filter, c.radius, x); };
    const double whole = integral(-c.radius, c.radius, value);
    EXPECT_NEAR(table.gain(),
                integral(-c.radius, c.radius, [&](double x) { return size_of(c, x); }) / whole,
                1e-5);
    const double variance =
        integral(-c.radius, c.radius, [&](double x) { return x * x * value(x); }) / whole;
    double sum = 0, squares = 0, signs = 0;
    constexpr int kSamples = 1 << 16;
    for (int i = 0; i < kSamples; ++i) {
      const FilterTable::Draw draw = table.draw((i + 0.5) / kSamples);
      const double weight = draw.negative ? -table.gain() : table.gain();
      sum += weight * draw.offset, squares += weight * draw.offset * draw.offset, signs += weight;
    }
    EXPECT_NEAR(signs / kSamples, 1, 1e-4);
    EXPECT_NEAR(sum / kSamples, 0, 1e-9);
    EXPECT_NEAR(squares / kSamples, variance, 1e-4 * c.radius * c.radius);
  }
}

TEST(PixelFilter, only_mitchell_has_negative_lobes) {
  for (const Case& c : kCases) {
    EXPECT_EQ(FilterTable(c.filter, c.radius).gain() > 1 + 1e-9, c.filter == PixelFilter::mitchell);
  }
  // Its zeros solve 7 t^3 - 36 t^2 + 60 t - 32 = 0, of which 8/7 lies between 1 and 2.
  const FilterTable table(PixelFilter::mitchell, 2);
  for (int i = 0; i < 1000; ++i) {
    const FilterTable::Draw draw = table.draw(i / 1000.0);
    EXPECT_EQ(draw.negative, std::abs(draw.offset) > 8.0 / 7);
  }
}

/// The value that a chi-square of `degrees` exceeds with the chance that a normal exceeds `z`
/// (Wilson and Hilferty 1931).
double chi_square_bound(int degrees, double z) {
  const double a = 2.0 / (9 * degrees);
  return degrees * std::pow(1 - a + z * std::sqrt(a), 3);
}

/// Of 200,000 independent samples over 24 x 24 cells, against the product of both axes.
double chi_square(const Case& drawn, const Case& expected) {
  constexpr int kCells = 24, kSamples = 200000;
  const Sampler sampler({.pattern = SamplePattern::independent,
                         .samples_per_pixel = kSamples,
                         .seed = 11,
                         .filter = drawn.filter,
                         .filter_radius = drawn.radius});
  std::vector<int> counts(size_t{kCells} * kCells);
  const auto cell = [&](double offset) {
    return static_cast<size_t>((offset / drawn.radius + 1) / 2 * kCells);
  };
  for (uint32_t i = 0; i < kSamples; ++i) {
    const Vec2 p = sampler.raster_point(0, 0, i);
    ++counts[cell(p.y - 0.5) * kCells + cell(p.x - 0.5)];
  }
  std::vector<double> shares;
  const auto size = [&](double x) { return size_of(expected, x); };
  const double r = expected.radius, whole = integral(-r, r, size);
  for (int i = 0; i < kCells; ++i) {
    shares.push_back(integral(-r + 2 * r * i / kCells, -r + 2 * r * (i + 1) / kCells, size) /
                     whole);
  }
  double sum = 0, rare = 0, rare_expected = 0;
  int degrees = -1;
  for (size_t i = 0; i < counts.size(); ++i) {
    const double e = kSamples * shares[i / kCells] * shares[i % kCells];
    if (e < 5) {
      rare += counts[i], rare_expected += e;
      continue;
    }
    sum += (counts[i] - e) * (counts[i] - e) / e;
    ++degrees;
  }
  if (rare_expected > 0) sum += (rare - rare_expected) * (rare - rare_expected) / rare_expected;
  if (rare_expected > 0) ++degrees;
  // A false alarm of one case in 1000, were the seed not fixed.
  return sum / chi_square_bound(degrees, 3.09);
}

TEST(PixelFilter, samples_pass_a_chi_square_test) {
  for (const Case& c : kCases) EXPECT_LT(chi_square(c, c), 1) << static_cast<int>(c.filter);
}

TEST(PixelFilter, the_chi_square_test_can_fail) {
  EXPECT_GT(chi_square({PixelFilter::gaussian, 2}, {PixelFilter::blackman_harris, 2}), 2);
}

}  // namespace
}  // namespace tessera
