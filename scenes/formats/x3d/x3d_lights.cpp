#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/math/elementary.h"
#include "scenes/formats/x3d/x3d_steps.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {

void X3dTranslator::add_light(const X3dNode& node, Nodes& out) {
  v1::Light light;
  light.set_name(node.def);
  const Vec3 location = values_.vec3(node, "location", {});
  constexpr Vec3 kAhead{0, 0, -1};
  Vec3 direction = values_.vec3(node, "direction", kAhead);
  const bool directional = node.type == "DirectionalLight";
  if (node.type != "PointLight" && direction == Vec3{}) {
    values_.repair(node, "direction", "a direction", "0 0 -1 is taken");
    direction = kAhead;
  }
  if (directional) {
    put_vec3(direction, light.mutable_directional()->mutable_direction());
  } else if (node.type == "PointLight") {
    put_vec3(location, light.mutable_point()->mutable_position());
  } else {
    // What the standard calls soft: full strength inside the beam width, nothing from the cut-off.
    const int version = document_.version();
    const double default_beam = version >= 40   ? 0.589049
                                : version >= 30 ? std::numbers::pi / 4
                                                : std::numbers::pi / 2;
    const double default_cut_off = version >= 30 ? std::numbers::pi / 2 : std::numbers::pi / 4;
    constexpr const char* kRange = "an angle above 0, up to pi";
    const double given = values_.angle(node, "cutOffAngle", default_cut_off);
    if (given <= 0) return values_.repair(node, "cutOffAngle", kRange, "the light is left out");
    const double cut_off =
        values_.clamped_angle(node, "cutOffAngle", given, kRange, std::numbers::pi);
    const double beam =
        values_.clamped_angle(node, "beamWidth", values_.angle(node, "beamWidth", default_beam),
                              "an angle of 0 to pi", std::numbers::pi);
    v1::Light::Spot& spot = *light.mutable_spot();
    put_vec3(location, spot.mutable_position());
    put_vec3(direction, spot.mutable_direction());
    spot.set_beam_width(portable::degrees(std::min(beam, cut_off)));
    spot.set_cut_off(portable::degrees(cut_off));
  }
  put(values_.color(node, "color", kWhite), light.mutable_color());
  light.set_intensity(values_.amount(node, "intensity", 1));
  light.set_ambient_intensity(values_.amount(node, "ambientIntensity", 0));
  light.set_off(!values_.boolean(node, "on", true));
  light.set_scoped(!values_.boolean(node, "global", !directional));
  light.set_shadows(values_.boolean(node, "shadows", false));
  light.set_shadow_intensity(values_.share(node, "shadowIntensity", 1));
  if (!directional) set_attenuation(node, light);
  *out.Add()->mutable_light() = std::move(light);
}

void X3dTranslator::set_attenuation(const X3dNode& node, v1::Light& light) {
  const Vec3 attenuation = values_.vec3(node, "attenuation", {1, 0, 0});
  if (!(attenuation == Vec3{1, 0, 0}) && !(attenuation == Vec3{})) {
    v1::Attenuation& factor = *light.mutable_attenuation();
    factor.set_constant(std::max(0., attenuation.x));
    factor.set_linear(std::max(0., attenuation.y));
    factor.set_quadratic(std::max(0., attenuation.z));
    factor.set_at_most_one(true);
  }
  if (attenuation.x < 0 || attenuation.y < 0 || attenuation.z < 0)
    values_.repair(node, "attenuation", "0 or more", "0 is taken for what is less");
  const double radius = values_.amount(node, "radius", 100);
  if (radius == 0)
    light.set_off(true);
  else
    light.set_radius(radius);
  light.set_ambient_attenuated(true);  // clause 17.2.2.4: the factors stand before the whole sum
}

}  // namespace tessera
