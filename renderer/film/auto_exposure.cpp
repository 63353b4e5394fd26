#include "renderer/film/auto_exposure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <vector>

#include "base/core_count.h"
#include "base/parallel.h"

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

constexpr double kMiddleGrey = 0.18;
constexpr double kLeftOut = 0.1;  ///< of the pixels, at either end

/// Counts of pixels by the binary logarithm of their luminance.
class Histogram {
 public:
  Histogram() {
    for (int part = 0; part < kBinsPerStop; ++part) {
      starts_[static_cast<size_t>(part)] = portable::exp(part * portable::log(2) / kBinsPerStop);
    }
  }
  /// `luminance` is finite and above 0.
  void add(double luminance) {
    int exponent = 0;
    const double part = 2 * std::frexp(luminance, &exponent);  // from 1 to 2
    const auto next = std::upper_bound(starts_.begin() + 1, starts_.end(), part);
    const int bin = (exponent - 1 + kMost) * kBinsPerStop + int(next - starts_.begin()) - 1;
    ++counts_[static_cast<size_t>(std::clamp(bin, 0, kBins - 1))];
    ++total_;
  }
  void add(const Histogram& other) {
    for (size_t bin = 0; bin < counts_.size(); ++bin) counts_[bin] += other.counts_[bin];
    total_ += other.total_;
  }
  bool empty() const { return total_ == 0; }
  /// Mean of what is left without the ends.
  double mean() const {
    const double low = kLeftOut * total_, high = (1 - kLeftOut) * total_;
    double below = 0, sum = 0;
    for (size_t bin = 0; bin < counts_.size(); ++bin) {
      const double above = below + counts_[bin];
      const double kept = std::max(0.0, std::min(above, high) - std::max(below, low));
      sum += kept * ((static_cast<double>(bin) + 0.5) / kBinsPerStop - kMost);
      below = above;
    }
    return sum / (high - low);
  }

 private:
  static constexpr int kMost = 64, kBinsPerStop = 256, kBins = 2 * kMost * kBinsPerStop + 1;
  std::array<double, kBinsPerStop> starts_{};  ///< of the bins from 1 on
  std::vector<uint32_t> counts_ = std::vector<uint32_t>(kBins);
  double total_ = 0;
};

/// The channel that is above 0 where a pixel shows a surface; -1: none tells.
int surface_channel(AovSet aovs) {
  for (const Aov aov : {Aov::alpha, Aov::depth, Aov::id}) {
    if (aovs.has(aov)) return aovs.first_channel(aov);
  }
  return -1;
}

}  // namespace

double auto_exposure(const Film& film) {
  const int tells = surface_channel(film.aovs());
  const std::span<const float> values = film.values();
  const auto channels = static_cast<size_t>(film.channels());
  Histogram histogram;
  std::mutex mutex;
  constexpr size_t kPixelsAtOnce = size_t{1} << 20;
  for_each_piece_parallel(
      values.size() / channels, kPixelsAtOnce, core_count(), [&](size_t begin, size_t end) {
        Histogram part;
        for (size_t at = begin * channels; at < end * channels; at += channels) {
          if (tells >= 0 && !(values[at + static_cast<size_t>(tells)] > 0)) continue;
          const double luminance =
              0.2126 * values[at] + 0.7152 * values[at + 1] + 0.0722 * values[at + 2];
          if (luminance > 0 && std::isfinite(luminance)) part.add(luminance);
        }
        const std::lock_guard lock(mutex);
        histogram.add(part);
      });
  if (histogram.empty()) return 0;
  const double stops = portable::log(kMiddleGrey) / portable::log(2) - histogram.mean();
  return std::round(100 * stops) / 100;
}

}  // namespace tessera
