#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/math/numbers.h"
#include "renderer/shading/image_texture.h"
#include "renderer/shading/light.h"
#include "renderer/shading/sky.h"

namespace tessera {

enum class BackgroundKind : uint8_t {
  solid,
  gradient_linear,
  gradient_absolute,
  rings,
  panorama_equirectangular,  ///< the picture's height is the angle from the zenith
  panorama_equal_area,       ///< it is the direction's y (Lambert's cylindrical projection)
  sun_and_sky,
};

#include "renderer/shading/panorama-inl.h"

/// What a ray sees that meets nothing. Immutable once built; thread-safe.
struct Background {
  BackgroundKind kind = BackgroundKind::solid;
  Color sky = kBlack;  ///< the one colour of a solid background
  Color ground = kBlack;
  /// Rings: colours with the angle (radians, increasing, the first 0) from the zenith or the nadir.
  struct Ring {
    double angle = 0;
    Color color;
  };
  std::vector<Ring> sky_rings, ground_rings;
  /// Panoramas: the picture, turned about +y by `angle` radians; at 0 its middle lies at -z and its
  /// right at +x.
  std::shared_ptr<const ImageTexture> picture;
  double angle = 0;
  double intensity = 1;
  /// Pictures on the faces of a cube, drawn over the colours; null: none there.
  enum Face { front, back, left, right, top, bottom };
  std::array<std::shared_ptr<const ImageTexture>, 6> cube;
  bool has_cube = false;
  std::shared_ptr<const Sky> daylight;  ///< of sun_and_sky; always there then
  bool has_sun_disc = true;             ///< else without the sun in it
  double transparency = 0;              ///< the share of colours and pictures that is not there
  double glow = 0;                      ///< adds glow * max(0, direction . way to it) of each light
  /// Rows of the rotation from world to background directions.
  std::array<Vec3, 3> rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

  /// Whether every ray sees the same.
  bool is_constant() const { return kind == BackgroundKind::solid && !has_cube && glow == 0; }
  /// Whether a ray sees a panorama and nothing else.
  bool is_plain_panorama() const {
    return (kind == BackgroundKind::panorama_equirectangular ||
            kind == BackgroundKind::panorama_equal_area) &&
           !has_cube && transparency == 0 && glow == 0;
  }
  Color panorama_at(double s, double t) const {
    // Beyond the outer rows' middles there is no other row: the zenith does not meet the nadir.
    const double half = 0.5 / picture->settings().height;
    return without_negative(picture->light(s, std::clamp(t, half, 1 - half))) * intensity;
  }
  /// Radiance along unit direction `d`, for a ray from `origin`.
  Color radiance(const Point3& origin, const Vec3& d, std::span<const Light> lights) const;
};

enum class FogKind : uint8_t { none, linear, exponential };

struct Fog {
  FogKind kind = FogKind::none;
  Color color = kWhite;
  double visibility_range = 0;  ///< metres, > 0 unless none

  /// The share of a surface's light that comes through `distance` metres; the rest is `color`.
  double clearness(double distance) const;
};

}  // namespace tessera
