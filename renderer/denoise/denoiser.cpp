#include "renderer/denoise/denoiser.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "base/cancellation.h"
#include "base/error.h"
#include "base/parallel.h"
#include "renderer/math/elementary.h"

namespace tessera {

namespace {

/// Pixels are looked for so far away, and compared by their surroundings of so far.
constexpr int kWindow = 8, kPatch = 3;
constexpr int kMargin = kWindow + kPatch;
/// How many standard deviations are alike, squared; and so of features.
constexpr float kColorScale = 0.45f * 0.45f, kFeatureScale = 0.6f * 0.6f;
/// Squared differences of features that never count.
constexpr float kLeastFeature = 1e-3f;
/// Beyond this distance a weight is nothing.
constexpr float kFarthest = 12;
constexpr int kBandRows = 16;

/// One channel with a margin about it, in which the nearest pixel is repeated.
class Plane {
 public:
  Plane() = default;
  Plane(const Film& film, int channel)
      : stride_(film.width() + 2 * kMargin),
        values_(static_cast<size_t>(stride_) * static_cast<size_t>(film.height() + 2 * kMargin)) {
    const int width = film.width(), height = film.height();
    for (int y = -kMargin; y < height + kMargin; ++y) {
      Cancellation::check();
      const int64_t row = int64_t{std::clamp(y, 0, height - 1)} * width;
      for (int x = -kMargin; x < width + kMargin; ++x) {
        const int64_t pixel = row + std::clamp(x, 0, width - 1);
        at(x, y) = film.values()[static_cast<size_t>(pixel * film.channels() + channel)];
      }
    }
  }
  float& at(int x, int y) { return values_[index(x, y)]; }
  /// The row from its first pixel on; up to kMargin before and behind are there too.
  const float* row(int y) const { return &values_[index(0, y)]; }

 private:
  size_t index(int x, int y) const {
    return static_cast<size_t>(int64_t{y + kMargin} * stride_ + x + kMargin);
  }
  int64_t stride_ = 0;
  std::vector<float> values_;
};

float squared(float a) { return a * a; }

/// Channels that are compared together, and by how much they differ between neighbours.
struct Feature {
  std::vector<Plane> planes;
  bool relative = false;  ///< differences count by the value's size

  /// Squared differences that are alike at that pixel: on slanted and curved surfaces more than on
  /// flat ones. The smaller of both sides: an edge is none.
  float tolerance(int x, int y) const {
    float slope = 0, size = 0;
    for (const Plane& plane : planes) {
      const float* const row = plane.row(y);
      const float here = row[x];
      slope += std::min(squared(row[x + 1] - here), squared(row[x - 1] - here)) +
               std::min(squared(plane.row(y + 1)[x] - here), squared(plane.row(y - 1)[x] - here));
      size += squared(here);
    }
    return std::max(slope, relative ? kLeastFeature * size : kLeastFeature) * kFeatureScale;
  }
};

class Denoiser {
 public:
  explicit Denoiser(const Film& film) : width_(film.width()), height_(film.height()) {
    const AovSet aovs = film.aovs();
    for (int c = 0; c < 3; ++c) {
      light_[static_cast<size_t>(c)] = Plane(film, c);
      variance_[static_cast<size_t>(c)] = Plane(film, aovs.first_channel(Aov::variance) + c);
    }
    features_[0].planes = planes(film, Aov::albedo, 3);
    features_[1].planes = planes(film, Aov::normal, 3);
    features_[2].planes = planes(film, Aov::depth, 1);
    features_[2].relative = true;
  }

  /// Rows from `first` up to `last` of the film, which this does not read.
  void smooth(int first, int last, Film& film) const {
    Band band(width_, last - first);
    for (int y = first; y < last; ++y) {
      for (int x = 0; x < width_; ++x) {
        for (size_t f = 0; f < features_.size(); ++f) {
          band.tolerance[f][band.at(x, y - first)] = 1 / features_[f].tolerance(x, y);
        }
      }
    }
    for (int dy = -kWindow; dy <= kWindow; ++dy) {
      Cancellation::check();
      for (int dx = -kWindow; dx <= kWindow; ++dx) {
        if (dx != 0 || dy != 0) add(dx, dy, first, last, band);
      }
    }
    for (int y = first; y < last; ++y) {
      for (int x = 0; x < width_; ++x) {
        const size_t at = band.at(x, y - first);
        float* const pixel =
            &film.values()[static_cast<size_t>((int64_t{y} * width_ + x) * film.channels())];
        for (size_t c = 0; c < 3; ++c) pixel[c] += band.change[c][at] / band.weight[at];
      }
    }
  }

  /// Gives a film back the light that this was made of.
  void restore(Film& film) const {
    const auto channels = static_cast<size_t>(film.channels());
    float* pixel = film.values().data();
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x, pixel += channels) {
        for (size_t c = 0; c < 3; ++c) pixel[c] = light_[c].row(y)[x];
      }
    }
  }

 private:
  /// What rows in work need.
  struct Band {
    Band(int width, int rows) : width_(width), row(static_cast<size_t>(width + 2 * kPatch)) {
      const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(rows);
      const size_t tall = static_cast<size_t>(width) * static_cast<size_t>(rows + 2 * kPatch);
      for (auto& values : tolerance) values.resize(pixels);
      for (auto& values : change) values.resize(pixels);
      weight.resize(pixels, 1);  // its own
      distance.resize(tall);
    }
    size_t at(int x, int y) const { return static_cast<size_t>(int64_t{y} * width_ + x); }

    int width_;
    std::array<std::vector<float>, 3> tolerance;  ///< by feature, one over it
    std::array<std::vector<float>, 3> change;     ///< by channel, weighted sums
    std::vector<float> weight, row;
    std::vector<float> distance;  ///< of light, summed along rows; from kPatch rows above
  };

  static std::vector<Plane> planes(const Film& film, Aov aov, int count) {
    std::vector<Plane> result;
    for (int c = 0; c < count; ++c) result.emplace_back(film, film.aovs().first_channel(aov) + c);
    return result;
  }

  /// Adds to each pixel of the rows the one that is dx, dy away.
  void add(int dx, int dy, int first, int last, Band& band) const {
    for (int y = first - kPatch; y < last + kPatch; ++y) {
      sum_distances(dx, dy, y, band, &band.distance[band.at(0, y - first + kPatch)]);
    }
    const int begin = std::max(0, -dx), end = std::min(width_, width_ - dx);
    for (int y = std::max(first, -dy); y < std::min(last, height_ - dy); ++y) {
      for (int x = begin; x < end; ++x) {
        float light = 0;
        for (int row = 0; row <= 2 * kPatch; ++row) {
          light += band.distance[band.at(x, y - first + row)];
        }
        constexpr float kShare = 1.0f / (3 * (2 * kPatch + 1) * (2 * kPatch + 1));
        float distance = std::max(light * kShare, 0.0f);
        if (!(distance <= kFarthest)) continue;
        const size_t at = band.at(x, y - first);
        for (size_t f = 0; f < features_.size(); ++f) {
          float apart = 0;
          for (const Plane& plane : features_[f].planes) {
            apart += squared(plane.row(y)[x] - plane.row(y + dy)[x + dx]);
          }
          distance = std::max(distance, apart * band.tolerance[f][at]);
        }
        if (!(distance <= kFarthest)) continue;
        const auto weight = static_cast<float>(portable::exp(-static_cast<double>(distance)));
        band.weight[at] += weight;
        for (size_t c = 0; c < 3; ++c) {
          // Differences, so that a plain area keeps its bits.
          band.change[c][at] += weight * (light_[c].row(y + dy)[x + dx] - light_[c].row(y)[x]);
        }
      }
    }
  }

  /// For each pixel of the row, over those beside it: how much more it differs from the one dx, dy
  /// away than their variances explain.
  void sum_distances(int dx, int dy, int y, Band& band, float* sums) const {
    std::fill(band.row.begin(), band.row.end(), 0.0f);
    for (size_t c = 0; c < 3; ++c) {
      const float* const here = light_[c].row(y);
      const float* const there = light_[c].row(y + dy) + dx;
      const float* const spread = variance_[c].row(y);
      const float* const its = variance_[c].row(y + dy) + dx;
      float* distance = band.row.data();
      for (int x = -kPatch; x < width_ + kPatch; ++x) {
        const float excess =
            squared(here[x] - there[x]) - (spread[x] + std::min(spread[x], its[x]));
        *distance++ += excess / (1e-10f + kColorScale * (spread[x] + its[x]));
      }
    }
    for (int x = 0; x < width_; ++x) {
      const float* const beside = &band.row[static_cast<size_t>(x)];
      float sum = 0;
      for (int i = 0; i <= 2 * kPatch; ++i) sum += beside[i];
      sums[x] = sum;
    }
  }

  int width_, height_;
  std::array<Plane, 3> light_, variance_;
  std::array<Feature, 3> features_;
};

}  // namespace

AovSet denoising_aovs() {
  return AovSet().with(Aov::albedo).with(Aov::normal).with(Aov::depth).with(Aov::variance);
}

void denoise(Film& film, int threads) {
  TESSERA_CHECK((film.aovs().bits() & denoising_aovs().bits()) == denoising_aovs().bits(),
                "the film lacks what denoising looks at");
  const Denoiser denoiser(film);
  const int bands = (film.height() + kBandRows - 1) / kBandRows;
  try {
    for_each_parallel(static_cast<size_t>(bands), threads, [&](size_t i) {
      const int first = static_cast<int>(i) * kBandRows;
      denoiser.smooth(first, std::min(first + kBandRows, film.height()), film);
    });
  } catch (...) {
    denoiser.restore(film);
    throw;
  }
}

}  // namespace tessera
