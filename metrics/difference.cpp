#include "metrics/difference.h"

#include <algorithm>
#include <cmath>

#include "base/core_count.h"
#include "base/error.h"
#include "base/parallel.h"

namespace tessera {
namespace {

/// Of some rows, and what the mean and the root are of.
struct Part {
  Difference difference;
  double sum = 0, sum_of_squares = 0;
};

/// Takes a pixel that differs into the part around all of them.
void include(int x, int y, Difference& d) {
  if (d.pixels_unequal++ == 0) d.x0 = x, d.y0 = y;
  d.x0 = std::min(d.x0, x), d.y0 = std::min(d.y0, y);
  d.x1 = std::max(d.x1, x + 1), d.y1 = std::max(d.y1, y + 1);
}

/// Takes what lies below it.
void add(Part& all, const Part& part) {
  all.sum += part.sum;
  all.sum_of_squares += part.sum_of_squares;
  Difference& d = all.difference;
  const Difference& more = part.difference;
  for (size_t i = 0; i < d.greatest_of.size(); ++i)
    d.greatest_of[i] = std::max(d.greatest_of[i], more.greatest_of[i]);
  if (more.greatest > d.greatest) {
    d.greatest = more.greatest;
    d.worst_pixel = more.worst_pixel;
  }
  d.pixels_beyond += more.pixels_beyond;
  if (more.pixels_unequal == 0) return;
  if (d.pixels_unequal == 0) d.x0 = more.x0, d.y0 = more.y0;
  d.x0 = std::min(d.x0, more.x0), d.y0 = std::min(d.y0, more.y0);
  d.x1 = std::max(d.x1, more.x1), d.y1 = std::max(d.y1, more.y1);
  d.pixels_unequal += more.pixels_unequal;
}

}  // namespace

Difference difference_of(std::span<const float> a, std::span<const float> b, size_t channels,
                         size_t width, double allowed) {
  TESSERA_CHECK(a.size() == b.size(),
                std::to_string(a.size()) + " and " + std::to_string(b.size()));
  // Parts that depend on the size of the picture alone, and so do the sums then.
  constexpr size_t kRowsOfPart = 64;
  const size_t rows = a.size() / channels / width;
  std::vector<Part> parts((rows + kRowsOfPart - 1) / kRowsOfPart);
  for_each_piece_parallel(rows, kRowsOfPart, core_count(), [&](size_t begin, size_t end) {
    Part& part = parts[begin / kRowsOfPart];
    Difference& d = part.difference;
    d.greatest_of.resize(channels);
    for (size_t pixel = begin * width; pixel < end * width; ++pixel) {
      double worst = 0;
      for (size_t i = 0; i < channels; ++i) {
        const double of = channel_difference(a[pixel * channels + i], b[pixel * channels + i]);
        d.greatest_of[i] = std::max(d.greatest_of[i], of);
        worst = std::max(worst, of);
        part.sum += of;
        part.sum_of_squares += of * of;
      }
      if (worst > d.greatest) {
        d.greatest = worst;
        d.worst_pixel = pixel;
      }
      if (worst > 0) include(static_cast<int>(pixel % width), static_cast<int>(pixel / width), d);
      if (worst > allowed) ++d.pixels_beyond;
    }
  });
  Part all;
  all.difference.greatest_of.resize(channels);
  for (const Part& part : parts) add(all, part);
  Difference& result = all.difference;
  const auto values = static_cast<double>(a.size());
  result.mean = all.sum / values;
  result.rmse = std::sqrt(all.sum_of_squares / values);
  return result;
}

}  // namespace tessera
