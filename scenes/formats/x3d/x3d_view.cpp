#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/file.h"
#include "scenes/formats/x3d/x3d_proto.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {

void X3dTranslator::put(const Color& color, v1::Color* out) const {
  const bool linear = options_.x3d_color == ReadOptions::Color::linear;
  out->set_r(linear ? linear_from_srgb(color.r) : color.r);
  out->set_g(linear ? linear_from_srgb(color.g) : color.g);
  out->set_b(linear ? linear_from_srgb(color.b) : color.b);
}

void X3dTranslator::add_camera(const X3dNode& node, const v1::Transform& path) {
  v1::Camera& camera = *out_.scene.add_cameras();
  const std::string description = values_.text(node, "description");
  camera.set_name(unique(camera_names_, !node.def.empty()      ? node.def
                                        : !description.empty() ? description
                                                               : "Viewpoint"));
  camera.set_description(description);
  v1::Transform& frame = *camera.mutable_world_from_camera();
  frame = path;
  add_translation(values_.vec3(node, "position", {0, 0, 10}), frame);
  add_rotation(values_.rotation(node, "orientation"), frame);
  if (node.type == "OrthoViewpoint") {
    const auto sides = values_.numbers(node, "fieldOfView", 4);
    v1::Orthographic& view = *camera.mutable_orthographic();
    if (sides.size() == 4) {
      if (!(sides[0] < sides[2] && sides[1] < sides[3]))
        throw document_.error(node.field("fieldOfView")->offset, "an empty field of view",
                              "minimum x and y below maximum x and y");
      view.set_min_x(sides[0]);
      view.set_min_y(sides[1]);
      view.set_max_x(sides[2]);
      view.set_max_y(sides[3]);
    }
  } else {
    const double angle = values_.number(node, "fieldOfView", std::numbers::pi / 4);
    if (!(angle > 0 && angle < std::numbers::pi))
      throw document_.error(node.field("fieldOfView")->offset, fmt::format("fieldOfView {}", angle),
                            "an angle between 0 and pi");
    camera.mutable_perspective()->set_field_of_view(degrees_from_radians(angle));
    camera.mutable_perspective()->set_axis(v1::Perspective::SMALLER);
  }
  camera.set_near_distance(std::max(0., values_.number(node, "nearDistance", -1)));
  camera.set_far_distance(std::max(0., values_.number(node, "farDistance", -1)));
  camera.set_frame_all(values_.boolean(node, "viewAll", false));
}

/// Every file has a viewpoint and a headlight, whether it says so or not.
void X3dTranslator::finish_cameras() {
  if (out_.scene.cameras_size() == 0) {
    v1::Camera& camera = *out_.scene.add_cameras();
    camera.set_name("default");
    add_translation({0, 0, 10}, *camera.mutable_world_from_camera());
    camera.mutable_perspective()->set_field_of_view(45);
  }
  if (navigation_ && !values_.boolean(*navigation_, "headlight", true)) return;
  for (v1::Camera& camera : *out_.scene.mutable_cameras()) {
    v1::Light& headlight = *camera.mutable_headlight();
    put_vec3({0, 0, -1}, headlight.mutable_directional()->mutable_direction());
  }
}

void X3dTranslator::add_light(const X3dNode& node, Nodes& out) {
  v1::Light light;
  light.set_name(node.def);
  const Vec3 location = values_.vec3(node, "location", {});
  const Vec3 direction = values_.vec3(node, "direction", {0, 0, -1});
  const bool directional = node.type == "DirectionalLight";
  if (node.type != "PointLight" && direction == Vec3{})
    throw document_.error(node.field("direction")->offset, "a direction of 0 0 0", "a direction");
  if (directional) {
    put_vec3(direction, light.mutable_directional()->mutable_direction());
  } else if (node.type == "PointLight") {
    put_vec3(location, light.mutable_point()->mutable_position());
  } else {
    // What the standard calls soft: full strength inside the beam width, nothing from the cut-off.
    const double default_beam = document_.version() >= 40 ? 0.589049 : std::numbers::pi / 4;
    const double cut_off = values_.number(node, "cutOffAngle", std::numbers::pi / 2);
    const double beam = values_.number(node, "beamWidth", default_beam);
    if (!(cut_off > 0 && cut_off <= std::numbers::pi))
      throw document_.error(node.field("cutOffAngle")->offset,
                            fmt::format("cutOffAngle {}", cut_off), "an angle above 0, up to pi");
    v1::Light::Spot& spot = *light.mutable_spot();
    put_vec3(location, spot.mutable_position());
    put_vec3(direction, spot.mutable_direction());
    spot.set_beam_width(degrees_from_radians(std::clamp(beam, 0., cut_off)));
    spot.set_cut_off(degrees_from_radians(cut_off));
  }
  put(values_.color(node, "color", kWhite), light.mutable_color());
  light.set_intensity(std::max(0., values_.number(node, "intensity", 1)));
  light.set_ambient_intensity(std::max(0., values_.number(node, "ambientIntensity", 0)));
  light.set_off(!values_.boolean(node, "on", true));
  light.set_scoped(!values_.boolean(node, "global", !directional));
  light.set_shadows(values_.boolean(node, "shadows", false));
  light.set_shadow_intensity(values_.share(node, "shadowIntensity", 1));
  if (!directional) {
    const Vec3 attenuation = values_.vec3(node, "attenuation", {1, 0, 0});
    if (!(attenuation == Vec3{1, 0, 0}) && !(attenuation == Vec3{})) {
      v1::Attenuation& factor = *light.mutable_attenuation();
      factor.set_constant(std::max(0., attenuation.x));
      factor.set_linear(std::max(0., attenuation.y));
      factor.set_quadratic(std::max(0., attenuation.z));
      factor.set_at_most_one(true);
    }
    const double radius = values_.number(node, "radius", 100);
    if (radius == 0)
      light.set_off(true);
    else
      light.set_radius(std::max(0., radius));
  }
  *out.Add()->mutable_light() = std::move(light);
}

namespace {

/// Angles in degrees, increasing and one fewer than the colours.
std::vector<double> ring_angles(std::vector<double> radians, size_t colors, double most,
                                Warnings& warnings) {
  if (radians.size() + 1 != colors && !(radians.empty() && colors == 0)) {
    warnings.add("a Background needs one angle fewer than colours; what is left over is left out");
    radians.resize(std::min(radians.size(), colors == 0 ? 0 : colors - 1));
  }
  double last = 0;
  for (double& angle : radians) {
    const double degrees = std::min(degrees_from_radians(angle), most);
    if (degrees < last) warnings.add("angles of a Background that fall are raised to the last one");
    // Equal angles make a sharp edge.
    angle = std::max(degrees, std::nextafter(last, 360));
    last = angle;
  }
  return radians;
}

}  // namespace

void X3dTranslator::set_background(const X3dNode& node, const v1::Transform& path) {
  v1::Background& background = *out_.scene.mutable_background();
  auto sky = values_.colors(node, "skyColor");
  auto ground = values_.colors(node, "groundColor");
  if (sky.empty()) sky.push_back(kBlack);
  auto sky_angles = values_.numbers(node, "skyAngle", 1);
  auto ground_angles = values_.numbers(node, "groundAngle", 1);
  background.set_transparency(values_.share(node, "transparency", 0));
  for (const X3dField& field : node.fields)
    if (field.name.ends_with("Url")) warnings_.add("pictures of a Background are not read yet");
  const bool plain = sky_angles.empty() && ground_angles.empty() && sky.size() == 1;
  if (plain && (ground.empty() || (ground.size() == 1 && ground[0] == sky[0]))) {
    put(sky[0], background.mutable_solid());
    return;
  }
  if (plain && ground.size() == 1) {
    // By the letter the ground colour would be seen nowhere: it stands for a gradient.
    put(sky[0], background.mutable_gradient()->mutable_sky());
    put(ground[0], background.mutable_gradient()->mutable_ground());
  } else {
    v1::Background::Rings& rings = *background.mutable_rings();
    sky_angles = ring_angles(std::move(sky_angles), sky.size(), 180, warnings_);
    ground_angles = ring_angles(std::move(ground_angles), ground.size(), 90, warnings_);
    sky.resize(std::min(sky.size(), sky_angles.size() + 1));
    ground.resize(std::min(ground.size(), ground_angles.size() + 1));
    for (const Color& color : sky) put(color, rings.add_sky());
    for (const Color& color : ground) put(color, rings.add_ground());
    rings.mutable_sky_angles()->Assign(sky_angles.begin(), sky_angles.end());
    rings.mutable_ground_angles()->Assign(ground_angles.begin(), ground_angles.end());
  }
  if (path.steps_size() > 0) *background.mutable_orientation() = path;
}

void X3dTranslator::set_fog(const X3dNode& node) {
  const double range = values_.number(node, "visibilityRange", 0);
  if (range <= 0) return;
  v1::Fog& fog = *out_.scene.mutable_fog();
  const std::string type = values_.text(node, "fogType");
  if (type == "EXPONENTIAL")
    fog.set_kind(v1::Fog::EXPONENTIAL);
  else if (!type.empty() && type != "LINEAR")
    throw document_.error(node.field("fogType")->offset, fmt::format("fogType '{}'", type),
                          "LINEAR or EXPONENTIAL");
  put(values_.color(node, "color", kWhite), fog.mutable_color());
  fog.set_visibility_range(range);
}

void X3dTranslator::set_settings() {
  v1::Settings& settings = *out_.scene.mutable_settings();
  if (options_.x3d_color == ReadOptions::Color::display)
    settings.mutable_output()->set_transfer(v1::Output::DISPLAY);
  settings.mutable_output()->set_tone_map(v1::Output::CLAMP);
  v1::IntegratorSettings& integrator = *settings.mutable_integrator();
  switch (options_.x3d_shadows) {
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

void X3dTranslator::set_metadata(const std::string& file) {
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
