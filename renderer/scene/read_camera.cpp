#include "renderer/scene/read_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <vector>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "renderer/scene/read_shading.h"
#include "renderer/scene/read_transform.h"

namespace tessera {

const v1::Camera* find_camera(const v1::Scene& scene, const std::string& name) {
  if (name.empty()) {
    return scene.cameras_size() > 0 ? &scene.cameras(0) : &v1::Camera::default_instance();
  }
  for (const v1::Camera& camera : scene.cameras()) {
    if (camera.name() == name) return &camera;
  }
  for (const v1::Camera& camera : scene.cameras()) {
    if (camera.description() == name) return &camera;
  }
  int number = 0;
  const auto end = name.data() + name.size();
  const auto [read_to, error] = std::from_chars(name.data(), end, number);
  if (error == std::errc() && read_to == end && number >= 1 && number <= scene.cameras_size()) {
    return &scene.cameras(number - 1);
  }
  return nullptr;
}

namespace {

void read_perspective(const Where& where, const v1::Perspective& in, CameraSettings& out) {
  if (in.has_field_of_view()) {
    out.field_of_view =
        portable::radians(checked(where, "perspective.field_of_view", in.field_of_view(),
                                  {.min = 0, .max = 180, .above_min = true, .below_max = true}));
  }
  constexpr Range kShift{.min = -1000, .max = 1000};
  out.shift = {checked(where, "perspective.shift_x", in.shift_x(), kShift),
               checked(where, "perspective.shift_y", in.shift_y(), kShift)};
  if (in.pixel_aspect() != 0) {
    out.pixel_aspect =
        checked(where, "perspective.pixel_aspect", in.pixel_aspect(), {.min = 0.001, .max = 1000});
  }
  switch (in.axis()) {
    case v1::Perspective::VERTICAL:
      out.axis = CameraSettings::Axis::vertical;
      break;
    case v1::Perspective::HORIZONTAL:
      out.axis = CameraSettings::Axis::horizontal;
      break;
    case v1::Perspective::LARGER:
      out.axis = CameraSettings::Axis::larger;
      break;
    default:
      out.axis = CameraSettings::Axis::smaller;
      break;
  }
}

void read_orthographic(const Where& where, const v1::Orthographic& in, CameraSettings& out) {
  out.projection = Projection::orthographic;
  if (in.has_min_x()) out.min_x = checked(where, "orthographic.min_x", in.min_x());
  if (in.has_min_y()) out.min_y = checked(where, "orthographic.min_y", in.min_y());
  if (in.has_max_x()) out.max_x = checked(where, "orthographic.max_x", in.max_x());
  if (in.has_max_y()) out.max_y = checked(where, "orthographic.max_y", in.max_y());
  if (out.min_x >= out.max_x || out.min_y >= out.max_y) {
    fail_value(where, "orthographic", "empty", "min_x < max_x and min_y < max_y");
  }
}

void read_panoramic(const Where& where, const v1::Panoramic& in, Projection projection,
                    CameraSettings& out) {
  out.projection = projection;
  Range range{.min = 0, .max = 360, .above_min = true};
  // The vertical axis of a cylinder is a tangent.
  if (projection == Projection::cylindrical) range.max = 180, range.below_max = true;
  const double angle = in.has_field_of_view() ? in.field_of_view() : 90;
  out.field_of_view = portable::radians(checked(where, "field_of_view", angle, range));
}

void read_lens(const Where& where, const v1::Lens& in, CameraSettings& settings) {
  LensSettings& out = settings.lens;
  out.radius.x = checked(where, "lens.radius_x", in.radius_x(), kNotNegative);
  out.radius.y = checked(where, "lens.radius_y", in.radius_y(), kNotNegative);
  if (out.is_pinhole()) return;
  out.radius_over_frame = in.radius_unit() == v1::Lens::METRES_OVER_FRAME;
  out.focal_distance = checked(where, "lens.focal_distance", in.focal_distance(), kPositive);
  out.focal_sphere = in.focal_surface() == v1::Lens::SPHERE;
  // Where rays run across the view there is no point of a plane to focus on.
  const bool is_plane_projection = settings.projection == Projection::perspective ||
                                   settings.projection == Projection::orthographic;
  if (!out.focal_sphere && !is_plane_projection) {
    fail_value(where, "lens.focal_surface", "PLANE", "SPHERE, for this projection");
  }
  constexpr double kMostSamples = 1 << 14;
  out.samples = static_cast<uint32_t>(
      checked(where, "lens.samples", in.samples(), {.min = 0, .max = kMostSamples}));
  out.samples = std::max(out.samples, 1u);
  switch (in.shape()) {
    case v1::Lens::POLYGON:
      out.shape = LensShape::polygon;
      out.blades =
          static_cast<uint32_t>(checked(where, "lens.blades", in.blades(), {.min = 3, .max = 64}));
      break;
    case v1::Lens::SQUARE_UNIFORM:
      out.shape = LensShape::square;
      break;
    case v1::Lens::GAUSSIAN:
      out.shape = LensShape::gaussian;
      break;
    case v1::Lens::LINE:
      out.shape = LensShape::line;
      break;
    default:
      out.shape = LensShape::circle;
      break;
  }
}

Affine read_frame(const Where& where, const v1::Camera& camera, bool is_default, double time) {
  if (is_default) return translation({0, 0, 10});
  const Affine frame = read_transform(where, camera.world_from_camera(), camera.keys(), time);
  if (!is_invertible(frame)) {
    fail_value(where, "world_from_camera", "flat", "a transform that can be inverted");
  }
  return frame;
}

}  // namespace

CameraChoice read_camera(const v1::Scene& scene, const std::string& name, double time) {
  const v1::Camera* found = find_camera(scene, name);
  if (!found) {
    std::vector<std::string> known;
    for (const v1::Camera& camera : scene.cameras()) known.push_back(camera.name());
    throw scene_error(fmt::format("there is no camera '{}' among the scene's {}{}", name,
                                  scene.cameras_size(), suggestion(name, known)));
  }
  const v1::Camera& camera = *found;
  const Where where{.kind = "camera", .name = camera.name()};
  CameraChoice choice;
  CameraSettings& out = choice.settings;
  out.world_from_camera = read_frame(where, camera, scene.cameras_size() == 0, time);
  switch (camera.projection_case()) {
    case v1::Camera::kPerspective:
      read_perspective(where, camera.perspective(), out);
      break;
    case v1::Camera::kOrthographic:
      read_orthographic(where, camera.orthographic(), out);
      break;
    case v1::Camera::kSpherical:
      read_panoramic(where, camera.spherical(), Projection::spherical, out);
      break;
    case v1::Camera::kCylindrical:
      read_panoramic(where, camera.cylindrical(), Projection::cylindrical, out);
      break;
    case v1::Camera::PROJECTION_NOT_SET:
      break;
  }
  if (camera.has_lens()) read_lens(where, camera.lens(), out);
  choice.frame_all = camera.frame_all();
  out.near_distance = checked(where, "near_distance", camera.near_distance(), kNotNegative);
  if (checked(where, "far_distance", camera.far_distance(), kNotNegative) > 0) {
    out.far_distance = checked(where, "far_distance", camera.far_distance(),
                               {.min = out.near_distance, .above_min = true});
  }
  if (camera.has_headlight() && !camera.headlight().off()) choice.headlight = &camera.headlight();
  return choice;
}

Light read_headlight(const v1::Light& in, const Affine& world_from_camera) {
  Light light = read_light({.kind = "headlight"}, in, world_from_camera);
  light.casts_shadow = false;
  return light;
}

}  // namespace tessera
