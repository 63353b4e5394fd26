#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/file.h"
#include "renderer/math/elementary.h"
#include "renderer/math/encodings.h"
#include "scenes/formats/x3d/x3d_steps.h"
#include "scenes/formats/x3d/x3d_translator.h"
#include "scenes/import/to_affine.h"

namespace tessera {

void X3dBuild::put(const Color& color, v1::Color* out_color) const {
  const bool linear = options.x3d_color == ReadOptions::Color::linear;
  out_color->set_r(linear ? srgb_to_linear(color.r) : color.r);
  out_color->set_g(linear ? srgb_to_linear(color.g) : color.g);
  out_color->set_b(linear ? srgb_to_linear(color.b) : color.b);
}

void X3dTranslator::add_camera(const X3dNode& node, const v1::Transform& path) {
  std::optional<v1::Camera> made = make_camera(node, path);
  if (!made) return;
  const std::string& description = made->description();
  made->set_name(build_.unique(build_.camera_names, !node.def.empty()      ? node.def
                                                    : !description.empty() ? description
                                                                           : "Viewpoint"));
  *out_.scene.add_cameras() = *std::move(made);
}

std::optional<v1::Camera> X3dTranslator::make_camera(const X3dNode& node,
                                                     const v1::Transform& path) const {
  v1::Camera camera;
  camera.set_description(values_.text(node, "description"));
  v1::Transform& frame = *camera.mutable_world_from_camera();
  frame = path;
  add_translation(values_.vec3(node, "position", {0, 0, 10}), frame);
  add_rotation(values_.rotation(node, "orientation"), frame);
  if (!is_invertible(to_affine(frame))) {
    values_.repair(node.offset, fmt::format("{} in a flat frame", describe(node)),
                   "a frame that can be inverted", "it is left out");
    return std::nullopt;
  }
  // A camera measures in metres, whatever the frame around it measures in.
  const double scale = mean_scale(path);
  if (node.type == "OrthoViewpoint") {
    const auto sides = values_.exactly(node, "fieldOfView", 4);
    v1::Orthographic& view = *camera.mutable_orthographic();
    const auto see = [&](double min_x, double min_y, double max_x, double max_y) {
      view.set_min_x(min_x * scale);
      view.set_min_y(min_y * scale);
      view.set_max_x(max_x * scale);
      view.set_max_y(max_y * scale);
    };
    if (scale != 1) see(-1, -1, 1, 1);
    if (sides.size() == 4) {
      if (sides[0] < sides[2] && sides[1] < sides[3]) {
        see(sides[0], sides[1], sides[2], sides[3]);
      } else {
        values_.repair(node, "fieldOfView", "minimum x and y below maximum x and y",
                       "-1 -1 1 1 is taken");
      }
    }
  } else {
    constexpr double kUsual = std::numbers::pi / 4;
    double angle = values_.angle(node, "fieldOfView", kUsual);
    if (!(angle > 0 && angle < std::numbers::pi)) {
      values_.repair(node, "fieldOfView", "an angle between 0 and pi", "pi / 4 is taken");
      angle = kUsual;
    }
    camera.mutable_perspective()->set_field_of_view(portable::degrees(angle));
    camera.mutable_perspective()->set_axis(v1::Perspective::SMALLER);
  }
  camera.set_near_distance(std::max(0., values_.number(node, "nearDistance", -1)) * scale);
  const double far_distance = values_.number(node, "farDistance", -1) * scale;
  if (far_distance > camera.near_distance())
    camera.set_far_distance(far_distance);
  else if (far_distance > 0)
    values_.repair(node, "farDistance", "more than nearDistance", "it is left out");
  camera.set_frame_all(values_.boolean(node, "viewAll", false));
  return camera;
}

/// Every file has a viewpoint and a headlight, whether it says so or not.
void X3dTranslator::finish_cameras() {
  if (out_.scene.cameras_size() == 0) *out_.scene.add_cameras() = default_camera();
  if (!build_.headlight) return;
  for (v1::Camera& camera : *out_.scene.mutable_cameras()) {
    v1::Light& headlight = *camera.mutable_headlight();
    put_vec3({0, 0, -1}, headlight.mutable_directional()->mutable_direction());
  }
}

void X3dTranslator::set_settings() {
  v1::Settings& settings = *out_.scene.mutable_settings();
  if (build_.options.x3d_color == ReadOptions::Color::display)
    settings.mutable_output()->set_transfer(v1::Output::DISPLAY);
  settings.mutable_output()->set_tone_map(v1::Output::CLAMP);
  v1::IntegratorSettings& integrator = *settings.mutable_integrator();
  integrator.set_kind("whitted");  // whose lighting equation X3D prescribes
  switch (build_.options.x3d_shadows) {
    case ReadOptions::Shadows::on:
      integrator.set_shadows(v1::IntegratorSettings::SHADOWS_ON);
      break;
    case ReadOptions::Shadows::file:
      integrator.set_shadows(v1::IntegratorSettings::SHADOWS_BY_LIGHT);
      break;
    case ReadOptions::Shadows::off:
      integrator.set_shadows(v1::IntegratorSettings::SHADOWS_OFF);
      break;
  }
}

void X3dTranslator::set_metadata() {
  const std::string& file = document_.name();
  v1::Metadata& metadata = *out_.scene.mutable_metadata();
  metadata.set_source_file(to_utf8(file.substr(file.rfind('/') + 1)));
  for (const auto& [name, content] : document_.metadata()) {
    if (name == "title")
      metadata.set_title(content);
    else if (name == "creator" || name == "author")
      metadata.set_author(content);
    else if (name == "generator")
      metadata.set_generator(content);
    else
      (*metadata.mutable_properties())[name] = content;
  }
}

}  // namespace tessera
