#include "renderer/film/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <new>

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

Film::Film(const PixelRect& rect)
    : rect_(rect), size_(static_cast<size_t>(rect.area()) * kFilmChannels), values_(black(size_)) {}

void Film::write(const PixelRect& tile, int first_row, int rows, std::span<const float> values) {
  const auto row_size = static_cast<size_t>(tile.width()) * kFilmChannels;
  TESSERA_CHECK(rect_.contains(tile) && first_row >= tile.y0 && first_row + rows <= tile.y1 &&
                    values.size() == row_size * static_cast<size_t>(rows),
                fmt::format("rows {}+{} of [{},{})x[{},{}), {} values", first_row, rows, tile.x0,
                            tile.x1, tile.y0, tile.y1, values.size()));
  for (int row = 0; row < rows; ++row) {
    const size_t offset = (static_cast<size_t>(first_row + row - rect_.y0) * width() +
                           static_cast<size_t>(tile.x0 - rect_.x0)) *
                          kFilmChannels;
    std::copy_n(values.begin() + static_cast<ptrdiff_t>(row_size) * row, row_size,
                values_.get() + offset);
  }
}

void Film::mark_hole(const PixelRect& tile) {
  constexpr int kCheckerSide = 8;
  for (int y = tile.y0; y < tile.y1; ++y) {
    for (int x = tile.x0; x < tile.x1; ++x) {
      const float level = ((x / kCheckerSide) ^ (y / kCheckerSide)) & 1 ? 1.0f : 0.0f;
      const size_t offset =
          (static_cast<size_t>(y - rect_.y0) * width() + static_cast<size_t>(x - rect_.x0)) *
          kFilmChannels;
      values_[offset] = level;
      values_[offset + 1] = 0;
      values_[offset + 2] = level;
    }
  }
}

std::string Film::pixels_sha256() const { return sha256_hex(std::as_bytes(values())); }

}  // namespace tessera
