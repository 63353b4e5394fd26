#include "coordinator/jobs/preview.h"

#include <algorithm>

#include "base/error.h"
#include "job/picture_settings.h"

namespace tessera {
namespace {

/// Numbers out of their range came from a client; a preview makes do without them.
OutputSettings settings_of(const v1::Output& output) {
  try {
    return picture_settings(output);
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

PreviewImage make_preview(const Film& film, const v1::Output& output, uint64_t tiles_done,
                          int most_side) {
  const int step = (std::max(film.width(), film.height()) + most_side - 1) / most_side;
  const int width = (film.width() + step - 1) / step, height = (film.height() + step - 1) / step;
  Film smaller({0, 0, width, height});
  const auto from = film.values();
  const auto to = smaller.values();
  const auto at = [](int x, int y, const Film& of) {
    const size_t pixel =
        static_cast<size_t>(y) * static_cast<size_t>(of.width()) + static_cast<size_t>(x);
    return pixel * static_cast<size_t>(of.channels());
  };
  for (int y = 0; y < film.height(); ++y) {
    const float* pixel = &from[at(0, y, film)];
    float* sum = &to[at(0, y / step, smaller)];
    for (int x = 0, left = step; x < film.width(); ++x, pixel += film.channels()) {
      for (size_t c = 0; c < kFilmChannels; ++c) sum[c] += pixel[c];
      if (--left > 0) continue;
      left = step;
      sum += kFilmChannels;
    }
  }
  for (int y = 0; y < height; ++y) {
    const int rows = std::min(step, film.height() - y * step);
    for (int x = 0; x < width; ++x) {
      const int columns = std::min(step, film.width() - x * step);
      for (size_t c = 0; c < kFilmChannels; ++c) {
        to[at(x, y, smaller) + c] /= static_cast<float>(rows * columns);
      }
    }
  }
  return {width, height, film.rect(), tiles_done, to_8_bit(smaller, settings_of(output))};
}

Film light_of(const FilmView& film) {
  Film light(film.rect);
  const auto channels = static_cast<ptrdiff_t>(film.channels);
  auto from = film.values.begin();
  for (auto to = light.values().begin(); to != light.values().end();
       to += ptrdiff_t{kFilmChannels}) {
    std::copy_n(from, kFilmChannels, to);
    from += channels;
  }
  return light;
}

}  // namespace tessera
