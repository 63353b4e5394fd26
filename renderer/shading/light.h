#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "renderer/math/numbers.h"

namespace tessera {

enum class LightKind : uint8_t { directional, point, spot, cylinder };

/// scale / (constant + linear d + quadratic d^2), d in the light's own frame.
struct LightAttenuation {
  double constant = 0, linear = 0, quadratic = 0;  ///< >= 0; all zero: no attenuation
  double scale = 1;
  bool at_most_one = false;  ///< the denominator is at least 1
  bool whole_path = false;   ///< d also counts the way back to the camera
  bool is_none() const { return constant == 0 && linear == 0 && quadratic == 0; }
  friend bool operator==(const LightAttenuation&, const LightAttenuation&) = default;
};

/// A light without extent, in world coordinates. A value.
struct Light {
  LightKind kind = LightKind::directional;
  Point3 position{};
  Vec3 direction{0, 0, -1};  ///< unit; the way light travels
  /// Radiance of a white Lambertian surface that faces the light, where attenuation is 1:
  /// irradiance over pi.
  Color intensity = kWhite;
  /// Added to the ambient light of what the light reaches.
  Color ambient = kBlack;
  bool ambient_attenuated = false;
  LightAttenuation attenuation{};
  /// Metres of the light's frame per metre of the world: one over the mean length of its axes.
  double frame_scale = 1;
  double radius = std::numeric_limits<double>::infinity();  ///< in the light's frame
  double beam_radius = 0;                                   ///< in the light's frame; of a cylinder
  double beam_width = 0;                                    ///< radians; full strength up to here
  double cut_off = 0;  ///< radians; none from here on; linear in angle between
  /// Cosines of angles at which the factor is surely 1 and surely 0; by themselves they decide
  /// nothing.
  double cos_full = 2, cos_none = -2;
  bool casts_shadow = true;
  double shadow_intensity = 1;  ///< share that an occluder takes
  double shadow_distance = std::numeric_limits<double>::infinity();  ///< metres of the world

  /// Whether all of it comes from `position`; else it comes along `direction`.
  bool is_placed() const { return kind == LightKind::point || kind == LightKind::spot; }
  /// Whether it is as strong in every direction that it goes out in.
  bool is_point_or_directional() const {
    return kind == LightKind::point || kind == LightKind::directional;
  }
};

#include "renderer/shading/light-inl.h"

/// sample_light() of any kind but point.
bool sample_shaped_light(const Light& light, const Point3& p, double path_length,
                         LightSample& sample);

/// False where nothing arrives at `p`; `path_length` is that from the camera to `p`.
inline bool sample_light(const Light& light, const Point3& p, double path_length,
                         LightSample& sample) {
  if (light.kind != LightKind::point) return sample_shaped_light(light, p, path_length, sample);
  return sample_place(light.position - p, sample) && attenuate(light, path_length, sample);
}

/// Sets cos_full and cos_none from the angles, so that most points need no arc.
void set_spot_cosines(Light& light);

/// 1 up to beam_width, 0 from cut_off on, linear in `angle` (radians) between.
double spot_factor(double angle, double beam_width, double cut_off);

}  // namespace tessera
