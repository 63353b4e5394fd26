#include "renderer/camera/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/math/elementary.h"

namespace tessera {

namespace {

struct HalfSize {
  double x, y;
};

/// Half of the image at distance 1. The side that `axis` names spans the angle (ISO/IEC 19775-1,
/// 23.3.1 for the smaller one).
HalfSize perspective_window(const CameraSettings& settings, double width, double height) {
  width *= settings.pixel_aspect;
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

/// How far the eye may go towards points, whose z is that way, until they fill a window of that
/// half width at a distance of 1 along one axis, wherever on this axis the eye is.
double farthest_eye(std::span<const Vec3> points, int axis, double half) {
  double low = -std::numeric_limits<double>::infinity(), high = low;
  for (const Vec3& p : points) {
    low = std::max(low, -p[axis] - half * p.z);
    high = std::max(high, p[axis] - half * p.z);
  }
  return -(low + high) / (2 * half);
}

/// Where on an axis the eye at depth z, before all points, sees as much of them to either side.
double middle_seen(std::span<const Vec3> points, int axis, double z) {
  double middle = 0;
  // What is outermost decides, and is found after a few times.
  for (int i = 0; i < 16; ++i) {
    const auto place = [&](const Vec3& p) { return (p[axis] - middle) / (p.z - z); };
    const auto [low, high] =
        std::minmax_element(points.begin(), points.end(),
                            [&](const Vec3& a, const Vec3& b) { return place(a) < place(b); });
    const double a = low->z - z, b = high->z - z;
    const double next = ((*low)[axis] * b + (*high)[axis] * a) / (a + b);
    if (next == middle) break;
    middle = next;
  }
  return middle;
}

/// The point of the image at distance 1 that lies in the frame's middle.
Vec2 window_center(const CameraSettings& settings, const HalfSize& half) {
  return {2 * half.x * settings.shift.x, 2 * half.y * settings.shift.y};
}

}  // namespace

Camera::Camera(const CameraSettings& settings, int frame_width, int frame_height)
    : projection_(settings.projection), lens_(settings.lens) {
  frame_.near_distance = settings.near_distance, frame_.far_distance = settings.far_distance;
  const Affine& m = settings.world_from_camera;
  const auto column = [&](size_t c) { return Vec3{m.m[0][c], m.m[1][c], m.m[2][c]}; };
  frame_.eye = Point3{} + column(3);
  frame_.view = -normalize(column(2));
  const Vec3 up = normalize(column(1));
  frame_.up = normalize(up - frame_.view * dot(up, frame_.view));
  frame_.right = cross(frame_.view, frame_.up);
  if (dot(frame_.right, column(0)) < 0) frame_.right = -frame_.right;

  const double width = frame_width, height = frame_height;
  if (lens_.radius_over_frame) {
    lens_.radius = {lens_.radius.x / width, lens_.radius.y / height};
  }
  Vec2 center;
  HalfSize half{};
  switch (projection_) {
    case Projection::perspective:
      half = perspective_window(settings, width, height);
      center = window_center(settings, half);
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
  frame_.scale = {2 * half.x / width, -2 * half.y / height};
  frame_.offset = {center.x - half.x, center.y + half.y};
}

Ray Camera::lens_ray(double x, double y, const Vec2& u) const {
  Ray ray = this->ray(x, y);
  const Vec2 p = sample_lens(lens_.shape, lens_.blades, u);
  const Vec3 on_lens = frame_.right * (p.x * lens_.radius.x) + frame_.up * (p.y * lens_.radius.y);
  const double to_focus = lens_.focal_sphere
                              ? lens_.focal_distance
                              : lens_.focal_distance / dot(ray.direction, frame_.view);
  ray.direction = normalize(ray.direction * to_focus - on_lens);
  ray.origin = ray.origin + on_lens;
  return ray;
}

Camera::PixelCone Camera::pixel_cone() const {
  const double side = std::sqrt(std::abs(frame_.scale.x * frame_.scale.y));
  if (projection_ == Projection::orthographic) return {side, 0};
  return {0, side};
}

CameraSettings framed_view(const CameraSettings& settings, int frame_width, int frame_height,
                           std::span<const Point3> points) {
  CameraSettings out = settings;
  const bool is_perspective = settings.projection == Projection::perspective;
  if (points.empty() || (!is_perspective && settings.projection != Projection::orthographic))
    return out;
  const Camera camera(settings, frame_width, frame_height);
  const HalfSize window = perspective_window(settings, frame_width, frame_height);
  const Vec2 center = is_perspective ? window_center(settings, window) : Vec2{};
  // Sheared so that a shifted window is in the middle, the move of the eye likewise.
  std::vector<Vec3> seen;  // across, up and away from the eye
  Bounds3 box;
  for (const Point3& point : points) {
    const Vec3 offset = point - camera.position();
    const double away = dot(offset, camera.view());
    seen.push_back({dot(offset, camera.right()) - center.x * away,
                    dot(offset, camera.up()) - center.y * away, away});
    box.extend(Point3{} + seen.back());
  }
  constexpr double kMargin = 1.04;  // of the picture's side over that of what is seen
  const Vec3 size = box.diagonal();
  const double before = std::max(settings.near_distance * kMargin, 1e-3 * size.z);
  Vec3 move;
  if (is_perspective) {
    const double half[] = {window.x / kMargin, window.y / kMargin};
    move.z = box.min.z - before;
    for (int a = 0; a < 2; ++a) move.z = std::min(move.z, farthest_eye(seen, a, half[a]));
    if (!(move.z < box.min.z)) move.z = box.min.z - 1;  // a point, of no size
    for (int a = 0; a < 2; ++a) (a == 0 ? move.x : move.y) = middle_seen(seen, a, move.z);
  } else {
    move.z = std::min(0., box.min.z - before);
    const Vec2 pad{size.x * (kMargin - 1) / 2, size.y * (kMargin - 1) / 2};
    if (size.x > 0 || size.y > 0) {
      out.min_x = box.min.x - pad.x, out.max_x = box.max.x + pad.x;
      out.min_y = box.min.y - pad.y, out.max_y = box.max.y + pad.y;
    }
  }
  const Vec3 to = camera.right() * (move.x + center.x * move.z) +
                  camera.up() * (move.y + center.y * move.z) + camera.view() * move.z;
  for (size_t row = 0; row < 3; ++row) out.world_from_camera.m[row][3] += to[static_cast<int>(row)];
  return out;
}

std::optional<Vec2> Camera::raster_of(const Point3& p) const {
  const Vec3 offset = p - frame_.eye;
  double u = dot(offset, frame_.right), v = dot(offset, frame_.up);
  if (projection_ == Projection::perspective) {
    constexpr double kClearlyBefore = 1e-6;  // as a share of the distance
    const double depth = dot(offset, frame_.view);
    if (!(depth > kClearlyBefore * length(offset))) return std::nullopt;
    u /= depth;
    v /= depth;
  } else if (projection_ != Projection::orthographic) {
    return std::nullopt;
  }
  return Vec2{(u - frame_.offset.x) / frame_.scale.x, (v - frame_.offset.y) / frame_.scale.y};
}

Ray Camera::other_ray(double x, double y) const {
  const double u = frame_.offset.x + x * frame_.scale.x;
  const double v = frame_.offset.y + y * frame_.scale.y;
  Ray ray{frame_.eye, frame_.view, frame_.near_distance, frame_.far_distance};
  switch (projection_) {
    case Projection::perspective:
      break;
    case Projection::orthographic:
      ray.origin = frame_.eye + frame_.right * u + frame_.up * v;
      break;
    case Projection::spherical: {
      const double cos_v = portable::cos(v);
      ray.direction =
          normalize(frame_.view * (portable::cos(u) * cos_v) +
                    frame_.right * (portable::sin(u) * cos_v) + frame_.up * portable::sin(v));
      break;
    }
    case Projection::cylindrical:
      ray.direction = normalize(frame_.view * portable::cos(u) + frame_.right * portable::sin(u) +
                                frame_.up * v);
      break;
  }
  return ray;
}

}  // namespace tessera
