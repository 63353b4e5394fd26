#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace tessera {

/// How long things took: their number by what they took at most, and the sum. A plain value.
struct SecondsHistogram {
  static constexpr std::array kBounds = {0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1,
                                         0.3,    1.0,    3.0,   10.0,  30.0, 100.0};
  std::array<uint64_t, kBounds.size() + 1> counts{};  ///< the last: longer than all bounds
  double sum = 0;

  void note(double seconds) {
    const auto bound = std::lower_bound(kBounds.begin(), kBounds.end(), seconds);
    ++counts[static_cast<size_t>(bound - kBounds.begin())];
    sum += seconds;
  }
};

}  // namespace tessera
