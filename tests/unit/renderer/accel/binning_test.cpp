#include "renderer/accel/binning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/uniform_numbers.h"

namespace tessera::binning {
namespace {

constexpr float kMost = std::numeric_limits<float>::max();

BuildBox box_between(const Lanes& a, const Lanes& b, uint32_t index) {
  BuildBox box;
  box.low = lane_min(a, b);
  box.high = lane_max(a, b);
  box.set_index(index);
  return box;
}

/// Boxes whose corners are up to `reach` from the origin on each axis.
std::vector<BuildBox> boxes_within(const Vec3& reach, size_t count, UniformNumbers& numbers) {
  const auto part = [&](double most) { return static_cast<float>(numbers.between(-most, most)); };
  const auto corner = [&] { return Lanes{part(reach.x), part(reach.y), part(reach.z), 0}; };
  std::vector<BuildBox> boxes;
  for (uint32_t i = 0; i < count; ++i) boxes.push_back(box_between(corner(), corner(), i));
  return boxes;
}

/// Every bin of `boxes` is in range, and each way to tell the side of a split says the same.
void expect_total(const std::vector<BuildBox>& boxes, const Binning& binning) {
  for (const BuildBox& b : boxes) {
    const std::array<int, 3> at = binning(b);
    for (int axis = 0; axis < 3; ++axis) {
      const int bin = at[static_cast<size_t>(axis)];
      ASSERT_GE(bin, 0);
      ASSERT_LT(bin, binning.bins);
      for (int split = 1; split < binning.bins; ++split)
        ASSERT_EQ(binning.is_below(b, axis, split), bin < split) << bin << " " << split;
    }
  }
}

TEST(Binning, SplitsBoxesOfAnyExtent) {
  UniformNumbers numbers(1);
  for (const double reach : {1e-30, 1.0, 1e19, 1.7e38, 2.5e38, double{kMost}}) {
    for (const Vec3& axes : {Vec3{1, 1, 1}, Vec3{1, 1e-30, 1e-30}, Vec3{0, 0, 1}}) {
      for (const size_t count : {100, 1000, 10000}) {
        const std::vector<BuildBox> boxes = boxes_within(axes * reach, count, numbers);
        const Range range = make_range(boxes.data(), 0, boxes.size());
        const Binning binning(range);
        expect_total(boxes, binning);
        Bins bins(binning.bins);
        bins.add(binning, boxes.data(), 0, boxes.size());
        const Split split = bins.best(binning, 2);
        ASSERT_GE(split.axis, 0) << "reach " << reach;
        EXPECT_TRUE(std::isfinite(split.cost));
        size_t below = 0;
        for (const BuildBox& b : boxes) below += binning.is_below(b, split.axis, split.bin);
        EXPECT_GT(below, 0u);
        EXPECT_LT(below, count);
      }
    }
  }
}

TEST(Binning, PutsWhatIsNotFiniteIntoSomeBin) {
  const float inf = kInf, nan = std::numeric_limits<float>::quiet_NaN();
  const float odd[] = {nan, inf, -inf, kMost, -kMost, 0, 1e-45f, 1};
  UniformNumbers numbers(2);
  for (int i = 0; i < 2000; ++i) {
    const auto corner = [&] {
      return Lanes{odd[numbers.below(8)], odd[numbers.below(8)], odd[numbers.below(8)], 0};
    };
    std::vector<BuildBox> boxes;
    for (uint32_t k = 0; k < 20; ++k) {
      boxes.emplace_back();
      boxes.back().low = corner();
      boxes.back().high = corner();
      boxes.back().set_index(k);
    }
    expect_total(boxes, Binning(make_range(boxes.data(), 0, boxes.size())));
    // A range that the boxes were not taken from.
    expect_total(boxes, Binning(make_range(boxes.data(), 0, boxes.size() / 4)));
  }
  BuildBox strange = box_between(Lanes{}, Lanes{1, 1, 1, 0}, 0);
  const BuildBox other = box_between(Lanes{2, 2, 2, 0}, Lanes{3, 3, 3, 0}, 1);
  const BuildBox both[] = {strange, other};
  const Binning binning(make_range(both, 0, std::size(both)));
  strange.low[1] = nan;
  EXPECT_EQ(binning(strange)[1], 0);
  EXPECT_EQ(binning(other)[1], binning.bins - 1);
}

}  // namespace
}  // namespace tessera::binning
