#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/formats/x3d/x3d_steps.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {

namespace {

/// Angles in degrees, increasing and one fewer than the colours.
template <typename Warn>
std::vector<double> ring_angles(std::vector<double> radians, size_t colors, double most,
                                const Warn& warn) {
  if (radians.size() + 1 != colors && !(radians.empty() && colors == 0)) {
    warn("a Background needs one angle fewer than colours; what is left over is left out");
    radians.resize(std::min(radians.size(), colors == 0 ? 0 : colors - 1));
  }
  double last = 0;
  for (double& angle : radians) {
    const double degrees = std::min(degrees_from_radians(angle), most);
    if (degrees < last) warn("angles of a Background that fall are raised to the last one");
    // Equal angles make a sharp edge.
    angle = std::max(degrees, std::nextafter(last, 360));
    last = angle;
  }
  return radians;
}

}  // namespace

void X3dTranslator::set_background(const X3dNode& node, const v1::Transform& path) {
  v1::Background& background = *out_.scene.mutable_background();
  set_sky(node, background);
  background.set_transparency(values_.share(node, "transparency", 0));
  v1::Background::Cube cube;
  cube.set_front(sky_texture(node, "front"));
  cube.set_back(sky_texture(node, "back"));
  cube.set_left(sky_texture(node, "left"));
  cube.set_right(sky_texture(node, "right"));
  cube.set_top(sky_texture(node, "top"));
  cube.set_bottom(sky_texture(node, "bottom"));
  if (cube.ByteSizeLong() > 0) *background.mutable_cube() = std::move(cube);
  const bool turns = background.has_cube() || !background.has_solid();
  if (path.steps_size() > 0 && turns) *background.mutable_orientation() = path;
}

void X3dTranslator::set_sky(const X3dNode& node, v1::Background& background) {
  auto sky = values_.colors(node, "skyColor");
  auto ground = values_.colors(node, "groundColor");
  if (sky.empty()) sky.push_back(kBlack);
  auto sky_angles = values_.angles(node, "skyAngle");
  auto ground_angles = values_.angles(node, "groundAngle");
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
    const auto warn_at = [&](const char* angles) {
      const X3dField* field = node.field(angles);
      return [this, offset = field ? field->offset : node.offset](const char* what) {
        values_.warn(offset, what);
      };
    };
    sky_angles = ring_angles(std::move(sky_angles), sky.size(), 180, warn_at("skyAngle"));
    ground_angles =
        ring_angles(std::move(ground_angles), ground.size(), 90, warn_at("groundAngle"));
    sky.resize(std::min(sky.size(), sky_angles.size() + 1));
    ground.resize(std::min(ground.size(), ground_angles.size() + 1));
    for (const Color& color : sky) put(color, rings.add_sky());
    for (const Color& color : ground) put(color, rings.add_ground());
    rings.mutable_sky_angles()->Assign(sky_angles.begin(), sky_angles.end());
    rings.mutable_ground_angles()->Assign(ground_angles.begin(), ground_angles.end());
  }
}

void X3dTranslator::set_fog(const X3dNode& node, const v1::Transform& path) {
  build_.has_fog = true;
  const double range = values_.number(node, "visibilityRange", 0) * mean_scale(path);
  if (range <= 0) return;
  v1::Fog& fog = *out_.scene.mutable_fog();
  const std::string type = values_.text(node, "fogType");
  if (type == "EXPONENTIAL")
    fog.set_kind(v1::Fog::EXPONENTIAL);
  else if (!type.empty() && type != "LINEAR")
    values_.repair(node, "fogType", fmt::format("fogType '{}'", type), "LINEAR or EXPONENTIAL",
                   "LINEAR is taken");
  put(values_.color(node, "color", kWhite), fog.mutable_color());
  fog.set_visibility_range(range);
}

}  // namespace tessera
