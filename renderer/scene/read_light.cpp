#include <algorithm>

#include "renderer/math/elementary.h"
#include "renderer/scene/read_shading.h"

namespace tessera {

namespace {

LightAttenuation read_attenuation(const Where& where, const v1::Attenuation& in) {
  LightAttenuation out;
  out.constant = checked(where, "attenuation.constant", in.constant(), kNotNegative);
  out.linear = checked(where, "attenuation.linear", in.linear(), kNotNegative);
  out.quadratic = checked(where, "attenuation.quadratic", in.quadratic(), kNotNegative);
  if (in.has_scale()) out.scale = checked(where, "attenuation.scale", in.scale(), kNotNegative);
  out.at_most_one = in.at_most_one();
  out.whole_path = in.distance() == v1::Attenuation::PATH;
  return out;
}

void read_spot(const Where& where, const v1::Light::Spot& in, Light& out) {
  constexpr Range kHalfTurn{.min = 0, .max = 180};
  out.kind = LightKind::spot;
  out.position = checked_point(where, "spot.position", in.position());
  out.direction = checked_direction(where, "spot.direction", in.direction());
  out.beam_width = portable::radians(checked(where, "spot.beam_width", in.beam_width(), kHalfTurn));
  out.cut_off = portable::radians(checked(where, "spot.cut_off", in.cut_off(), kHalfTurn));
  set_spot_cosines(out);
}

void read_cylinder(const Where& where, const v1::Light::Cylinder& in, Light& out) {
  out.kind = LightKind::cylinder;
  out.position = checked_point(where, "cylinder.position", in.position());
  out.direction = checked_direction(where, "cylinder.direction", in.direction());
  out.beam_radius = checked(where, "cylinder.beam_radius", in.beam_radius(), kNotNegative);
}

void read_kind(const Where& where, const v1::Light& in, Light& out) {
  switch (in.kind_case()) {
    case v1::Light::kDirectional:
      out.kind = LightKind::directional;
      out.direction =
          checked_direction(where, "directional.direction", in.directional().direction());
      return;
    case v1::Light::kPoint:
      out.kind = LightKind::point;
      out.position = checked_point(where, "point.position", in.point().position());
      return;
    case v1::Light::kSpot:
      return read_spot(where, in.spot(), out);
    case v1::Light::kCylinder:
      return read_cylinder(where, in.cylinder(), out);
    case v1::Light::KIND_NOT_SET:
      break;
  }
  fail_value(where, "its kind", "missing", "directional, point, spot or cylinder");
}

double mean_axis_length(const Affine& affine) {
  double sum = 0;
  for (size_t c = 0; c < 3; ++c) {
    sum += length(Vec3{affine.m[0][c], affine.m[1][c], affine.m[2][c]});
  }
  return sum / 3;
}

}  // namespace

Light read_light(const Where& where, const v1::Light& in, const Affine& world_from_light) {
  Light out;
  read_kind(where, in, out);
  const Color color = in.has_color() ? checked(where, "color", in.color()) : kWhite;
  out.intensity = color * (in.has_intensity() ? checked(where, "intensity", in.intensity()) : 1);
  out.ambient = color * checked(where, "ambient_intensity", in.ambient_intensity(), kNotNegative);
  out.ambient_attenuated = in.ambient_attenuated();
  out.attenuation = read_attenuation(where, in.attenuation());
  if (checked(where, "radius", in.radius(), kNotNegative) > 0) out.radius = in.radius();
  if (in.has_shadow_intensity()) {
    out.shadow_intensity = checked(where, "shadow_intensity", in.shadow_intensity(), kUnitRange);
  }
  if (checked(where, "shadow_distance", in.shadow_distance(), kNotNegative) > 0) {
    out.shadow_distance = in.shadow_distance();
  }
  out.casts_shadow = in.shadows();
  out.position = world_from_light(out.position);
  out.direction = normalize(world_from_light(out.direction));
  out.frame_scale = 1 / mean_axis_length(world_from_light);
  return out;
}

}  // namespace tessera
