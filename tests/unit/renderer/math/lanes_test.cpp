#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "base/targets.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/math/elementary.h"
#include "renderer/math/rounding.h"
#include "tests/uniform_numbers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/unit/renderer/math/lanes_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/math/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// As many as a multiple of 8.
template <typename Function>
void each(const std::vector<double>& a, const std::vector<double>& b, std::vector<double>& out,
          const Function& function) {
  for (size_t i = 0; i < a.size(); i += kLanes)
    hn::StoreU(function(hn::LoadU(kLaneTag, &a[i]), hn::LoadU(kLaneTag, &b[i])), kLaneTag, &out[i]);
}
void atan2_of_all(const std::vector<double>& y, const std::vector<double>& x,
                  std::vector<double>& out) {
  each(y, x, out, [](Lanes a, Lanes b) HWY_ATTR { return arc_tangent(a, b); });
}
void next_of_all(const std::vector<double>& x, const std::vector<double>& way,
                 std::vector<double>& out) {
  each(x, way, out, [](Lanes a, Lanes b) HWY_ATTR { return next_towards(a, b); });
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {
namespace {

using Function = void (*)(const std::vector<double>&, const std::vector<double>&,
                          std::vector<double>&);
struct Code {
  Function atan2, next;
};
Code code_of(std::string_view name) {
  return {code_of_target(TESSERA_EACH_TARGET(atan2_of_all), name),
          code_of_target(TESSERA_EACH_TARGET(next_of_all), name)};
}

/// Of equal bits, so that zeros differ; any number that is none will do.
bool are_same(double a, double b) {
  return std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b) || (a != a && b != b);
}

std::vector<double> numbers(uint32_t seed, double smallest, double largest) {
  const double infinite = std::numeric_limits<double>::infinity();
  UniformNumbers random(seed);
  std::vector<double> out = {0., -0., 1, -1, infinite, -infinite, std::nan(""), 0x1p-1074};
  while (out.size() < 400'000) {
    const double size = std::exp2(random.between(smallest, largest));
    out.push_back(random.between(0, 1) < .5 ? size : -size);
  }
  return out;
}

TEST(Lanes, FindAnglesToTheBitsOfOne) {
  for (const BvhKernels& kernels : all_kernels()) {
    const Code code = code_of(kernels.name);
    for (const double range : {1., 40., 1000.}) {
      const auto y = numbers(3, -range, range), x = numbers(4, -range, range);
      std::vector<double> found(y.size());
      code.atan2(y, x, found);
      for (size_t i = 0; i < y.size(); ++i)
        ASSERT_TRUE(are_same(found[i], portable::atan2(y[i], x[i])))
            << kernels.name << ": " << y[i] << " " << x[i];
    }
  }
}

TEST(Lanes, FindTheNextNumbersOfOne) {
  const auto x = numbers(5, -1074, 1024), way = numbers(6, -10, 10);
  for (const BvhKernels& kernels : all_kernels()) {
    std::vector<double> found(x.size());
    // Each with every special way.
    for (size_t shift = 0; shift < 8; ++shift) {
      std::vector<double> ways(way.begin() + static_cast<ptrdiff_t>(shift), way.end());
      ways.insert(ways.end(), way.begin(), way.begin() + static_cast<ptrdiff_t>(shift));
      code_of(kernels.name).next(x, ways, found);
      for (size_t i = 0; i < x.size(); ++i) {
        const double next = ways[i] > 0 ? next_up(x[i]) : ways[i] < 0 ? next_down(x[i]) : x[i];
        ASSERT_TRUE(are_same(found[i], next)) << kernels.name << ": " << x[i] << " " << ways[i];
      }
    }
  }
}

}  // namespace
}  // namespace tessera
#endif  // HWY_ONCE
