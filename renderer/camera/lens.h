#pragma once

#include <cstdint>

#include "renderer/math/vec.h"

namespace tessera {

enum class LensShape : uint8_t { circle, polygon, square, gaussian, line };

/// The opening that a camera's rays come through. A value.
struct LensSettings {
  LensShape shape = LensShape::circle;
  uint32_t blades = 5;             ///< corners of a polygon, at least 3; the first lies at -x
  Vec2 radius;                     ///< metres along the image's x and y; zero: a pinhole
  bool radius_over_frame = false;  ///< divided by the frame's width and height in pixels
  double focal_distance = 1;       ///< metres
  bool focal_sphere = false;       ///< in focus is a sphere about the eye, not a plane
  uint32_t samples = 1;            ///< rays for each sample of the pixel

  bool is_pinhole() const { return radius.x == 0 && radius.y == 0; }
};

/// A point of a lens of radius 1, from two independent uniform numbers in [0, 1). Uniform over
/// circle, polygon (inscribed in the unit circle) and square ([-1, 1) on both axes); normal with
/// unit deviation on both axes; of triangular density over [-1, 1] on x.
Vec2 sample_lens(LensShape shape, uint32_t blades, const Vec2& u);

}  // namespace tessera
