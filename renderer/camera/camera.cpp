#include "renderer/camera/camera.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

struct HalfSize {
  double x, y;
};

/// Half of the image at distance 1. The side that `axis` names spans the angle (ISO/IEC 19775-1,
/// 23.3.1 for the smaller one).
HalfSize perspective_window(const CameraSettings& settings, double width, double height) {
  double side = std::min(width, height);
  switch (settings.axis) {
    case CameraSettings::Axis::smaller:
      break;
    case CameraSettings::Axis::vertical:
      side = height;
      break;
    case CameraSettings::Axis::horizontal:
      side = width;
      break;
    case CameraSettings::Axis::larger:
      side = std::max(width, height);
      break;
  }
  const double half = portable::tan(settings.field_of_view / 2);
  return {half * width / side, half * height / side};
}

}  // namespace

Camera::Camera(const CameraSettings& settings, int frame_width, int frame_height)
    : projection_(settings.projection),
      near_(settings.near_distance),
      far_(settings.far_distance),
      lens_(settings.lens) {
  const Affine& m = settings.world_from_camera;
  const auto column = [&](size_t c) { return Vec3{m.m[0][c], m.m[1][c], m.m[2][c]}; };
  eye_ = Point3{} + column(3);
  view_ = -normalize(column(2));
  const Vec3 up = normalize(column(1));
  up_ = normalize(up - view_ * dot(up, view_));
  right_ = cross(view_, up_);
  if (dot(right_, column(0)) < 0) right_ = -right_;

  const double width = frame_width, height = frame_height;
  if (lens_.radius_over_frame) {
    lens_.radius = {lens_.radius.x / width, lens_.radius.y / height};
  }
  Vec2 center;
  HalfSize half{};
  switch (projection_) {
    case Projection::perspective:
      half = perspective_window(settings, width, height);
      break;
    case Projection::orthographic: {
      center = {(settings.min_x + settings.max_x) / 2, (settings.min_y + settings.max_y) / 2};
      half = {(settings.max_x - settings.min_x) / 2, (settings.max_y - settings.min_y) / 2};
      half.x = std::max(half.x, half.y * width / height);
      half.y = std::max(half.y, half.x * height / width);
      break;
    }
    case Projection::spherical:
      half.y = settings.field_of_view / 2;
      half.x = half.y * width / height;
      break;
    case Projection::cylindrical:
      half.y = portable::tan(settings.field_of_view / 2);
      half.x = settings.field_of_view / 2 * width / height;
      break;
  }
  scale_ = {2 * half.x / width, -2 * half.y / height};
  offset_ = {center.x - half.x, center.y + half.y};
}

Ray Camera::lens_ray(double x, double y, const Vec2& u) const {
  Ray ray = this->ray(x, y);
  const Vec2 p = sample_lens(lens_.shape, lens_.blades, u);
  const Vec3 on_lens = right_ * (p.x * lens_.radius.x) + up_ * (p.y * lens_.radius.y);
  const double to_focus =
      lens_.focal_sphere ? lens_.focal_distance : lens_.focal_distance / dot(ray.direction, view_);
  ray.direction = normalize(ray.direction * to_focus - on_lens);
  ray.origin = ray.origin + on_lens;
  return ray;
}

Camera::PixelCone Camera::pixel_cone() const {
  const double side = std::sqrt(std::abs(scale_.x * scale_.y));
  if (projection_ == Projection::orthographic) return {side, 0};
  return {0, side};
}

CameraSettings grown_view(const CameraSettings& settings, int frame_width, int frame_height,
                          std::span<const Point3> corners) {
  CameraSettings out = settings;
  const double width = frame_width, height = frame_height;
  const Camera camera(settings, frame_width, frame_height);
  constexpr double kMargin = 1.02;
  double back = 0;  // metres by which the eye moves
  if (settings.projection == Projection::perspective) {
    const HalfSize half = perspective_window(settings, width, height);
    for (const Point3& corner : corners) {
      const Vec3 offset = corner - camera.position();
      const double depth = dot(offset, camera.view());
      const double across = std::max(std::abs(dot(offset, camera.right())) / half.x,
                                     std::abs(dot(offset, camera.up())) / half.y);
      // What fits the frame exactly is inside it.
      if (depth > 0 && across <= depth && depth >= settings.near_distance) continue;
      back = std::max({back, across * kMargin - depth, settings.near_distance * kMargin - depth});
    }
  } else if (settings.projection == Projection::orthographic) {
    Vec2 low{out.min_x, out.min_y}, high{out.max_x, out.max_y};
    for (const Point3& corner : corners) {
      const Vec3 offset = corner - camera.position();
      const double u = dot(offset, camera.right()), v = dot(offset, camera.up());
      low = {std::min(low.x, u), std::min(low.y, v)};
      high = {std::max(high.x, u), std::max(high.y, v)};
      back = std::max(back, settings.near_distance - dot(offset, camera.view()));
    }
    // A side that moves goes a little farther than needed.
    const double pad_x = (high.x - low.x) * (kMargin - 1), pad_y = (high.y - low.y) * (kMargin - 1);
    if (low.x < out.min_x) out.min_x = low.x - pad_x;
    if (low.y < out.min_y) out.min_y = low.y - pad_y;
    if (high.x > out.max_x) out.max_x = high.x + pad_x;
    if (high.y > out.max_y) out.max_y = high.y + pad_y;
    back *= kMargin;
  }
  const Vec3 move = camera.view() * -back;
  for (size_t row = 0; row < 3; ++row) {
    out.world_from_camera.m[row][3] += move[static_cast<int>(row)];
  }
  return out;
}

std::optional<Vec2> Camera::raster_of(const Point3& p) const {
  const Vec3 offset = p - eye_;
  double u = dot(offset, right_), v = dot(offset, up_);
  if (projection_ == Projection::perspective) {
    constexpr double kClearlyBefore = 1e-6;  // as a share of the distance
    const double depth = dot(offset, view_);
    if (!(depth > kClearlyBefore * length(offset))) return std::nullopt;
    u /= depth;
    v /= depth;
  } else if (projection_ != Projection::orthographic) {
    return std::nullopt;
  }
  return Vec2{(u - offset_.x) / scale_.x, (v - offset_.y) / scale_.y};
}

Ray Camera::other_ray(double x, double y) const {
  const double u = offset_.x + x * scale_.x;
  const double v = offset_.y + y * scale_.y;
  Ray ray{eye_, view_, near_, far_};
  switch (projection_) {
    case Projection::perspective:
      break;
    case Projection::orthographic:
      ray.origin = eye_ + right_ * u + up_ * v;
      break;
    case Projection::spherical: {
      const double cos_v = portable::cos(v);
      ray.direction = normalize(view_ * (portable::cos(u) * cos_v) +
                                right_ * (portable::sin(u) * cos_v) + up_ * portable::sin(v));
      break;
    }
    case Projection::cylindrical:
      ray.direction = normalize(view_ * portable::cos(u) + right_ * portable::sin(u) + up_ * v);
      break;
  }
  return ray;
}

}  // namespace tessera
