#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace tessera {

/// Pixels x0 <= x < x1, y0 <= y < y1 of the whole frame; row 0 is the top one.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  /// Exact for any rect inside a legal frame.
  int64_t area() const { return empty() ? 0 : int64_t{width()} * height(); }
  bool contains(const PixelRect& r) const {
    return r.x0 >= x0 && r.y0 >= y0 && r.x1 <= x1 && r.y1 <= y1;
  }
  friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

/// Channels of light: linear red, green, blue. The first of every pixel.
inline constexpr int kFilmChannels = 3;
/// Bounds on a frame: a side, and the product of both.
inline constexpr int kMaxFrameSide = 65536;
inline constexpr int64_t kMaxFramePixels = int64_t{1} << 28;

/// The unit of work: trace these samples of these pixels.
struct RenderTask {
  PixelRect rect;
  uint32_t first_sample = 0;
  uint32_t sample_count = 1;
  friend bool operator==(const RenderTask&, const RenderTask&) = default;
};

/// What tracing did, by the names that --stats prints ("rays_primary", "node_visits" ...). Each
/// value is a sum over pixels; what depends on the order of tiles too is told where it is counted.
using CounterMap = std::map<std::string, uint64_t>;

/// A traced tile: the mean of its samples, and what was asked for beside that; rect.area() x
/// channels values, rows from the top.
struct TilePixels {
  PixelRect rect;
  std::vector<float> values;
  CounterMap counters;
  int channels = kFilmChannels;  ///< of a pixel, light first
};

}  // namespace tessera
