#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace tessera {

/// Ends of a 95 % band.
struct Band {
  double low = 0, high = 0;
};

/// Of an even count the mean of the middle two; 0 of none.
double median(std::vector<double> values);
/// By linear interpolation, `share` from 0 to 1; 0 of none.
double percentile(std::vector<double> values, double share);

/// The line y = intercept + slope x with the least squares of distances in y.
struct LineFit {
  double slope = 0, intercept = 0;
};
/// Both must be of one size; without two different x all is 0.
LineFit fit_line(std::span<const double> x, std::span<const double> y);

inline constexpr int kResamples = 10'000;

/// `count` numbers below `count`, drawn with replacement; the same ones on every host.
class Resampler {
 public:
  explicit Resampler(uint64_t seed = 1) : random_(seed) {}
  void draw(size_t count, std::vector<uint32_t>& picks) {
    picks.resize(count);
    for (uint32_t& pick : picks) pick = static_cast<uint32_t>(((random_() >> 32) * count) >> 32);
  }

 private:
  std::mt19937_64 random_;
};

/// The percentile bootstrap (Efron 1979): the middle 95 % of what `statistic` makes of resampled
/// seeds. It is called with the numbers of the seeds to take, so that values that belong together
/// stay so.
template <typename Statistic>
Band bootstrap_band(size_t seeds, const Statistic& statistic, int resamples = kResamples) {
  if (seeds == 0) return {};
  Resampler resampler;
  std::vector<uint32_t> picks;
  std::vector<double> values;
  values.reserve(static_cast<size_t>(resamples));
  for (int i = 0; i < resamples; ++i) {
    resampler.draw(seeds, picks);
    values.push_back(statistic(std::span<const uint32_t>(picks)));
  }
  return {percentile(values, .025), percentile(values, .975)};
}

}  // namespace tessera
