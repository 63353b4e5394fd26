#include "renderer/shading/light.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

/// By the arc tangent: the arc cosine of a dot product loses half of the digits near the axis.
double angle_between(const Vec3& a, const Vec3& b) {
  return portable::atan2(length(cross(a, b)), dot(a, b));
}

double spot_factor_towards(const Light& light, const Vec3& direction) {
  const double cosine = dot(direction, light.direction);
  if (cosine > light.cos_full) return 1;
  if (cosine < light.cos_none) return 0;
  return spot_factor(angle_between(direction, light.direction), light.beam_width, light.cut_off);
}

bool sample_cylinder(const Light& light, const Point3& p, LightSample& sample) {
  const Vec3 offset = p - light.position;
  sample.distance = dot(offset, light.direction);
  const Vec3 across = offset - light.direction * sample.distance;
  sample.wi = -light.direction;
  return sample.distance > 0 && length(across) * light.frame_scale <= light.beam_radius;
}

}  // namespace

void set_spot_cosines(Light& light) {
  constexpr double kMargin = 1e-12;  // far above the rounding of a cosine
  light.cos_full = portable::cos(std::min(light.beam_width, light.cut_off)) + kMargin;
  light.cos_none = portable::cos(light.cut_off) - kMargin;
}

double spot_factor(double angle, double beam_width, double cut_off) {
  if (angle >= cut_off) return 0;
  if (angle <= beam_width) return 1;
  return (angle - cut_off) / (beam_width - cut_off);
}

bool sample_shaped_light(const Light& light, const Point3& p, double path_length,
                         LightSample& sample) {
  if (light.kind == LightKind::directional) {
    sample = {-light.direction, std::numeric_limits<double>::infinity(), 1};
    return true;
  }
  if (light.kind == LightKind::cylinder) {
    return sample_cylinder(light, p, sample) && attenuate(light, path_length, sample);
  }
  if (!sample_place(light.position - p, sample) || !attenuate(light, path_length, sample))
    return false;
  sample.factor *= spot_factor_towards(light, -sample.wi);
  return sample.factor > 0;
}

}  // namespace tessera
