#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "renderer/camera/lens.h"
#include "renderer/math/numbers.h"
#include "renderer/math/transform.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/ray.h"

namespace tessera {

enum class Projection : uint8_t { perspective, orthographic, spherical, cylindrical };

struct CameraSettings {
  enum class Axis : uint8_t { smaller, vertical, horizontal, larger };

  Affine world_from_camera{};  ///< the axes' lengths do not matter; may mirror
  Projection projection = Projection::perspective;
  double field_of_view = 0.78539816339744830962;  ///< radians over `axis`; vertical if panoramic
  Axis axis = Axis::smaller;
  /// How far the middle of the frame lies right of the view axis and above it, in widths and
  /// heights of the frame, and the width of a pixel over its height. Perspective only.
  Vec2 shift{};
  double pixel_aspect = 1;
  /// The orthographic window in metres; its shorter side grows to the frame's shape.
  double min_x = -1, min_y = -1, max_x = 1, max_y = 1;
  double near_distance = 0;  ///< metres along the ray; 0: no bound
  double far_distance = std::numeric_limits<double>::infinity();
  LensSettings lens{};
};

/// `settings` moved, and not turned, until `points` fill the frame but for a small margin, as much
/// to the left as to the right and as far up as down; of an orthographic camera the window changes
/// too. Panoramas are left alone.
CameraSettings framed_view(const CameraSettings& settings, int frame_width, int frame_height,
                           std::span<const Point3> points);

/// The view of a camera whose rays leave one point: through the raster point (x, y) along view +
/// right * u + up * v, (u, v) being offset + (x, y) * scale.
struct Pinhole {
  Point3 eye;
  Vec3 view, right, up;  ///< unit and square to each other
  Vec2 offset, scale;
  double near_distance = 0, far_distance = 0;  ///< metres along the ray
};

#include "renderer/camera/pinhole-inl.h"

/// From raster points of a whole frame to rays. A crop is a part of the same frame, so
/// its rays have the same bits. Immutable; thread-safe.
class Camera {
 public:
  Camera(const CameraSettings& settings, int frame_width, int frame_height);

  /// The ray of a pinhole through raster point (x, y), y downwards from the frame's top left
  /// corner. Its direction is of unit length.
  Ray ray(double x, double y) const {
    if (projection_ != Projection::perspective) return other_ray(x, y);
    return {frame_.eye, pinhole_direction(frame_, x, y), frame_.near_distance, frame_.far_distance};
  }
  /// Null for other projections than the perspective one; lives as long as this.
  const Pinhole* pinhole() const {
    return projection_ == Projection::perspective ? &frame_ : nullptr;
  }
  /// The ray through the point of the lens that the uniform numbers `u` choose.
  Ray lens_ray(double x, double y, const Vec2& u) const;
  /// How many rays through the lens make one sample; 0: there is no lens.
  uint32_t lens_samples() const { return lens_.is_pinhole() ? 0 : lens_.samples; }

  /// The raster point whose ray passes through `p`; nothing where `p` is not clearly before the
  /// camera, or the projection is no plane one.
  std::optional<Vec2> raster_of(const Point3& p) const;

  /// How wide the patch of one pixel is at a distance along its ray: at_eye + distance * spread;
  /// the middle of the frame stands for all of it.
  struct PixelCone {
    double at_eye = 0, spread = 0;
  };
  PixelCone pixel_cone() const;

  const Vec3& right() const { return frame_.right; }
  const Vec3& up() const { return frame_.up; }
  const Point3& position() const { return frame_.eye; }
  /// Metres along a ray at which it ends; infinite: nowhere.
  double far_distance() const { return frame_.far_distance; }
  /// Unit; the way that the camera looks.
  const Vec3& view() const { return frame_.view; }

 private:
  /// ray() of any projection but the perspective one.
  Ray other_ray(double x, double y) const;

  Projection projection_;
  /// Its offset + (x, y) * scale are a place on the image plane, or in panoramas angles.
  Pinhole frame_;
  LensSettings lens_;  ///< its radius in metres
};

}  // namespace tessera
