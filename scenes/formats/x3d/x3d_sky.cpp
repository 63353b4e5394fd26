#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/plural.h"
#include "renderer/math/elementary.h"
#include "scenes/formats/x3d/x3d_steps.h"
#include "scenes/formats/x3d/x3d_translator.h"
#include "scenes/import/to_affine.h"

namespace tessera {

namespace {

/// Angles in degrees, increasing and one fewer than the colours, of those in radians up to `most`,
/// which `expected` tells.
std::vector<double> ring_angles(const X3dValues& values, const X3dNode& node, const char* name,
                                std::vector<double> angles, size_t colors, double most,
                                const char* expected) {
  if (angles.size() + 1 != colors && !(angles.empty() && colors == 0)) {
    const X3dField* field = node.field(name);
    values.repair(
        node, name, field ? field->offset : node.offset,
        fmt::format("{} for {}", counted(angles.size(), "angle"), counted(colors, "colour")),
        "one angle fewer than colours", "what is left over is left out");
    angles.resize(std::min(angles.size(), colors == 0 ? 0 : colors - 1));
  }
  std::vector<double> degrees;
  double before = 0;
  for (const double angle : angles) {
    const double inside = values.clamped_angle(node, name, angle, expected, most);
    if (inside < before)
      values.repair(node, name, "angles that do not fall", "they are raised to the last one");
    before = std::max(before, inside);
    // Equal angles make a sharp edge.
    const double last = degrees.empty() ? 0 : degrees.back();
    degrees.push_back(std::max(portable::degrees(inside), std::nextafter(last, 360)));
  }
  return degrees;
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
  if (path.steps_size() == 0 || !turns) return;
  if (is_invertible(to_affine(path)))
    *background.mutable_orientation() = path;
  else
    values_.repair(node.offset, fmt::format("{} in a flat frame", describe(node)),
                   "a frame that can be inverted", "it is not turned");
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
    sky_angles = ring_angles(values_, node, "skyAngle", std::move(sky_angles), sky.size(),
                             std::numbers::pi, "angles of 0 to pi");
    ground_angles = ring_angles(values_, node, "groundAngle", std::move(ground_angles),
                                ground.size(), std::numbers::pi / 2, "angles of 0 to pi / 2");
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
  const double range = values_.amount(node, "visibilityRange", 0) * mean_scale(path);
  if (range == 0) return;
  v1::Fog& fog = *out_.scene.mutable_fog();
  constexpr std::array<std::string_view, 2> kTypes{"LINEAR", "EXPONENTIAL"};
  if (values_.choice(node, "fogType", kTypes) == 1) fog.set_kind(v1::Fog::EXPONENTIAL);
  put(values_.color(node, "color", kWhite), fog.mutable_color());
  fog.set_visibility_range(range);
}

}  // namespace tessera
