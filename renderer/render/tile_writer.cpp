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
  float* value = put_color(shown(sum, error), value_at(x, y));
  if (aovs_.aovs().empty()) return;
  aovs_.write(x, y, first_sample_, seen, sum, beside_light_, progress_, value);
}

}  // namespace tessera
