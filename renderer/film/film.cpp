#include "renderer/film/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <new>
#include <vector>

#include "base/cancellation.h"
#include "base/digest.h"
#include "base/error.h"

namespace tessera {

static_assert(std::endian::native == std::endian::little, "pixels are hashed as they lie");

namespace {

/// Black, but not yet there: a page comes with its first pixel, so that no tile waits for memory to
/// be cleared.
float* black(size_t size) {
  auto* const values = static_cast<float*>(std::calloc(std::max<size_t>(size, 1), sizeof(float)));
  if (values == nullptr) throw std::bad_alloc();
  return values;
}

}  // namespace

Film::Film(const PixelRect& rect, AovSet aovs)
    : rect_(rect),
      aovs_(aovs),
      channels_(aovs.channels()),
      size_(static_cast<size_t>(rect.area()) * static_cast<size_t>(channels_)),
      values_(black(size_)) {}

void Film::write(const PixelRect& tile, int first_row, int rows, std::span<const float> values) {
  const auto channels = static_cast<size_t>(channels_);
  const auto row_size = static_cast<size_t>(tile.width()) * channels;
  TESSERA_CHECK(rect_.contains(tile) && first_row >= tile.y0 && first_row + rows <= tile.y1 &&
                    values.size() == row_size * static_cast<size_t>(rows),
                fmt::format("rows {}+{} of [{},{})x[{},{}), {} values", first_row, rows, tile.x0,
                            tile.x1, tile.y0, tile.y1, values.size()));
  for (int row = 0; row < rows; ++row) {
    const size_t offset = (static_cast<size_t>(first_row + row - rect_.y0) * width() +
                           static_cast<size_t>(tile.x0 - rect_.x0)) *
                          channels;
    std::copy_n(values.begin() + static_cast<ptrdiff_t>(row_size) * row, row_size,
                values_.get() + offset);
  }
}

void Film::mark_hole(const PixelRect& tile) {
  constexpr int kCheckerSide = 8;
  const auto channels = static_cast<size_t>(channels_);
  for (int y = tile.y0; y < tile.y1; ++y) {
    float* at = values_.get() + (static_cast<size_t>(y - rect_.y0) * width() +
                                 static_cast<size_t>(tile.x0 - rect_.x0)) *
                                    channels;
    std::fill_n(at, static_cast<size_t>(tile.width()) * channels, 0.0f);
    for (int x = tile.x0; x < tile.x1; ++x, at += channels) {
      if (((x / kCheckerSide) ^ (y / kCheckerSide)) & 1) at[0] = at[2] = 1.0f;
      if (aovs_.has(Aov::alpha)) at[aovs_.first_channel(Aov::alpha)] = 1.0f;
    }
  }
}

Film Film::with_only(AovSet aovs) const {
  Film result(rect_, aovs);
  // Runs of channels that stay: {from, to, how many}.
  struct Run {
    int from, to, count;
  };
  std::vector<Run> runs{{0, 0, kFilmChannels}};
  for (const Aov aov : aovs.members()) {
    runs.push_back({aovs_.first_channel(aov), aovs.first_channel(aov),
                    AovSet().with(aov).channels() - kFilmChannels});
  }
  const float* from = values_.get();
  float* to = result.values_.get();
  constexpr int64_t kPixelsBetweenLooks = int64_t{1} << 20;
  for (int64_t i = 0; i < rect_.area(); ++i, from += channels_, to += result.channels_) {
    if (i % kPixelsBetweenLooks == 0) Cancellation::check();
    for (const Run& run : runs) std::copy_n(from + run.from, run.count, to + run.to);
  }
  return result;
}

std::string Film::pixels_sha256() const {
  if (!aovs_.empty()) return with_only({}).pixels_sha256();
  return sha256_hex(std::as_bytes(values()));
}

}  // namespace tessera
