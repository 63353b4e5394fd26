#pragma once

#include <cstdint>

#include "renderer/math/rounding.h"

namespace tessera::portable {

// To about 107 bits.
inline constexpr DoubleDouble kPi2{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
inline constexpr DoubleDouble kPiDd{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

/// Arc tangents of the multiples of 1/8.
inline constexpr DoubleDouble kArc[9] = {{0, 0},
                                         {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                         {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                         {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                         {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                         {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                         {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                         {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                         {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}};

/// Of the quick way to an arc tangent, that of one number and that of lanes alike.
struct QuickArc {
  /// Of the larger and the smaller part of the point: beyond, a product or what it leaves may
  /// underflow or overflow.
  static constexpr double kLeast = 1e-100, kMost = 1e100, kLeastRatio = 1e-30;
  /// Nearly halves are rounded down, so that the difference small - c * large, of the nearest
  /// multiple c of 1/8, fits into a double.
  static constexpr double kNearlyHalf = 0.4999;
  /// The last 27 bits of a double: what it and the rest are multiplied with may have 26 for an
  /// exact product.
  static constexpr uint64_t kLastBits = 0x7ffffff;
  /// atan(t) = t + t * (k3 * t^2 + k5 * t^4 + ...): the Taylor series, its last term a division.
  static constexpr double k3 = -1.0 / 3, k5 = 1.0 / 5, k7 = -1.0 / 7, k9 = 1.0 / 9, k11 = -1.0 / 11,
                          k13 = 1.0 / 13, kBy15 = 15;
  /// What the sum may be off by, of its tail and of the whole: far more than it ever is.
  static constexpr double kTailDoubt = 0x1p-48, kSumDoubt = 0x1p-100;
};

}  // namespace tessera::portable
