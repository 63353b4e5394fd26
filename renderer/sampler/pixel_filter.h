#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

/// How samples spread about a pixel's centre, by inverting the cumulative distribution along each
/// axis, so that every sample weighs the same, but for a sign, and pixels share none. Every filter
/// is a product of one function of each axis.
enum class PixelFilter {
  box,
  tent,
  gaussian,         ///< of deviation radius / 3, less its value at the radius
  mitchell,         ///< B = C = 1/3 (Mitchell and Netravali 1988); has negative lobes
  blackman_harris,  ///< the window of four terms (Harris 1978)
};

/// Pixels, where nothing else is asked for.
double default_radius(PixelFilter filter);

/// Of one axis, at `x` pixels from the centre, unnormalised; 0 from the radius on.
double filter_value(PixelFilter filter, double radius, double x);

/// Draws from the size of a filter of one axis, |f|. What stands for f is the line through 512
/// points of each half: less than 1e-5 of the peak beside it. That line is drawn from exactly, in
/// closed form. A value; thread-safe.
class FilterTable {
 public:
  /// `radius` in pixels, above 0.
  FilterTable(PixelFilter filter, double radius);

  struct Draw {
    double offset = 0;      ///< pixels from the centre, in [-radius, radius); grows with `u`
    bool negative = false;  ///< the filter is below 0 there
  };
  /// `u` in [0, 1).
  Draw draw(double u) const;
  /// The integral of |f| over that of f: 1 where it has no negative lobes.
  double gain() const { return gain_; }

 private:
  /// From its near end on: [begin, begin + width), |f| from `near` to `far`.
  struct Cell {
    double begin = 0, width = 0, near = 0, far = 0;
    double before = 0;  ///< area of the cells nearer to the centre
    bool negative = false;
  };
  std::vector<Cell> cells_;      ///< outwards
  std::vector<uint16_t> guide_;  ///< first cell that may hold a share i / size of the area
  double area_ = 0, gain_ = 1;
};

}  // namespace tessera
