#include "renderer/render/tile_writer.h"

#include <cmath>

namespace tessera {

/// Of its light, or of how that was found.
Color TileWriter::shown(const SampleSum& sum, std::optional<double> error) const {
  const View view = scene_.settings.view;
  if (view == View::samples) return kWhite * sum.count();
  if (view != View::error) return sum.mean();
  if (error) return kWhite * *error;
  const Color variance = sum.variance();
  return kWhite * std::sqrt((variance.r + variance.g + variance.b) / 3);
}

void TileWriter::put(const SampleSum& sum, int x, int y, bool seen, std::optional<double> error) {
  Color color = shown(sum, error);
  double alpha = 0;
  if (aovs_.aovs().has(Aov::alpha) && seen) {
    const DirectBackground background =
        aovs_.background_of(x, y, first_sample_, sum.count(), beside_light_, progress_);
    color = color - background.light;
    alpha = 1 - (background.share.r + background.share.g + background.share.b) / 3;
  }
  float* value = put_color(color, value_at(x, y));
  if (aovs_.aovs().empty()) return;
  aovs_.write(x, y, first_sample_, seen, sum, alpha, beside_light_, progress_, value);
}

}  // namespace tessera
