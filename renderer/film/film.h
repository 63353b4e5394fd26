#pragma once

#include <cstdlib>
#include <memory>
#include <span>
#include <string>

#include "renderer/film/tile.h"

namespace tessera {

/// The linear picture of the crop window `rect` of a frame. Values are radiance, unbounded.
class Film {
 public:
  explicit Film(const PixelRect& rect);

  const PixelRect& rect() const { return rect_; }
  int width() const { return rect_.width(); }
  int height() const { return rect_.height(); }

  /// Copies rows [first_row, first_row + rows) of `tile` (frame coordinates) from `values`.
  void write(const PixelRect& tile, int first_row, int rows, std::span<const float> values);
  /// Paints the marker of a tile that was never rendered: a magenta and black checker.
  void mark_hole(const PixelRect& tile);

  /// width x height x kFilmChannels values, rows from the top.
  std::span<const float> values() const { return {values_.get(), size_}; }
  std::span<float> values() { return {values_.get(), size_}; }
  /// SHA-256 of values() as little-endian bytes.
  std::string pixels_sha256() const;

 private:
  struct Free {
    void operator()(float* values) const { std::free(values); }
  };

  PixelRect rect_;
  size_t size_;
  std::unique_ptr<float[], Free> values_;
};

}  // namespace tessera
