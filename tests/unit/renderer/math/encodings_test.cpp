#include "renderer/math/encodings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tessera {
namespace {

TEST(Encodings, SrgbMeetsItsEndsAndItsMiddle) {
  EXPECT_EQ(srgb_to_linear(0), 0);
  EXPECT_EQ(srgb_to_linear(1), 1);
  EXPECT_DOUBLE_EQ(srgb_to_linear(0.04), 0.04 / 12.92);
  EXPECT_NEAR(srgb_to_linear(0.5), 0.21404114048223255, 1e-15);
}

TEST(Encodings, EveryHalfComesBack) {
  for (uint32_t half = 0; half < 0x10000; ++half) {
    const float value = half_to_float(static_cast<uint16_t>(half));
    if ((half & 0x7c00) == 0x7c00 && (half & 0x3ff) != 0) {
      EXPECT_TRUE(std::isnan(value)) << half;
      continue;
    }
    EXPECT_EQ(float_to_half(value), half);
  }
}

TEST(Encodings, HalvesAreTheNearest) {
  EXPECT_EQ(half_to_float(0x3c00), 1.0f);
  EXPECT_EQ(half_to_float(0x0001), 0x1p-24f);
  EXPECT_EQ(half_to_float(0xfbff), -65504.0f);
  EXPECT_EQ(float_to_half(1 + 0x1p-11f), 0x3c00);      // a tie goes to the even one
  EXPECT_EQ(float_to_half(1 + 3 * 0x1p-11f), 0x3c02);  // and here up
  EXPECT_EQ(float_to_half(1 + 0x1.8p-11f), 0x3c01);
  EXPECT_EQ(float_to_half(65519), 0x7bff);
  EXPECT_EQ(float_to_half(65520), 0x7c00);
  EXPECT_EQ(float_to_half(0x1p-25f), 0);
  EXPECT_TRUE(std::isnan(half_to_float(float_to_half(std::numeric_limits<float>::quiet_NaN()))));
}

}  // namespace
}  // namespace tessera
