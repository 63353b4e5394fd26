#pragma once

#include <cstdlib>
#include <memory>
#include <span>
#include <string>

#include "renderer/film/aov.h"
#include "renderer/film/tile.h"

namespace tessera {

/// The linear picture of the crop window `rect` of a frame, and what was asked for beside it.
/// Values are radiance, unbounded.
class Film {
 public:
  explicit Film(const PixelRect& rect, AovSet aovs = {});

  const PixelRect& rect() const { return rect_; }
  int width() const { return rect_.width(); }
  int height() const { return rect_.height(); }
  AovSet aovs() const { return aovs_; }
  /// Values of a pixel, light first.
  int channels() const { return channels_; }

  /// Copies rows [first_row, first_row + rows) of `tile` (frame coordinates) from `values`.
  void write(const PixelRect& tile, int first_row, int rows, std::span<const float> values);
  /// Paints the marker of a tile that was never rendered: a magenta and black checker, 0 beside it
  /// but for alpha.
  void mark_hole(const PixelRect& tile);

  /// width x height x channels values, rows from the top.
  std::span<const float> values() const { return {values_.get(), size_}; }
  std::span<float> values() { return {values_.get(), size_}; }
  /// A copy with `aovs` alone, which it has to have.
  Film with_only(AovSet aovs) const;
  /// SHA-256 of its light as little-endian bytes, whatever is beside it.
  std::string pixels_sha256() const;

 private:
  struct Free {
    void operator()(float* values) const { std::free(values); }
  };

  PixelRect rect_;
  AovSet aovs_;
  int channels_;
  size_t size_;
  std::unique_ptr<float[], Free> values_;
};

/// Bytes of the values of such a film.
inline uint64_t film_bytes(const PixelRect& rect, AovSet aovs) {
  return static_cast<uint64_t>(rect.area()) * static_cast<uint64_t>(aovs.channels()) *
         sizeof(float);
}

}  // namespace tessera
