#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace tessera {

/// A chi-square of so many standard deviations is a false alarm of one test in 300,000.
inline constexpr double kChiSquareAlarm = 4.5;

/// How many standard deviations the chi-square of counts of independent draws lies above what it is
/// on the mean where `expected` is right (Wilson and Hilferty 1931). Both have a cell for what
/// falls beside all others, so that their sums are the same. Cells of less than 20 go together.
/// `doubt` is the variance of what is expected, where that was estimated; or empty.
inline double chi_square_sigmas(std::span<const double> found, std::span<const double> expected,
                                std::span<const double> doubt = {}) {
  double chi2 = 0, rare_found = 0, rare_expected = 0, rare_doubt = 0;
  int freedom = -1;
  const auto add = [&](double count, double truth, double more) {
    chi2 += (count - truth) * (count - truth) / (truth + more);
    ++freedom;
  };
  for (size_t i = 0; i < expected.size(); ++i) {
    const double more = doubt.empty() ? 0 : doubt[i];
    if (expected[i] >= 20) {
      add(found[i], expected[i], more);
    } else {
      rare_found += found[i];
      rare_expected += expected[i];
      rare_doubt += more;
    }
  }
  // Where nothing at all can be, a single draw is too many.
  if (rare_expected > 0 || rare_found > 0)
    add(rare_found, std::max(rare_expected, 1e-3), rare_doubt);
  const double spread = 2.0 / (9 * std::max(freedom, 1));
  return (std::cbrt(chi2 / std::max(freedom, 1)) - (1 - spread)) / std::sqrt(spread);
}

}  // namespace tessera
