#include "scenes/formats/crt/crt_objects.h"

namespace tessera {
namespace {

/// The way from one attribute's place to the other's.
Vec3 way(CrtAttributes& in, std::string_view from, std::string_view to) {
  const Vec3 offset = in.vector(to) - in.vector(from);
  if (in.has(from) && in.has(to) && !(length(offset) > 0))
    in.fail(in.where(), "a light where it points to", "two different points");
  return normalize(offset);
}

void read_falloff(CrtAttributes& in, v1::Light& light) {
  const double falloff = in.number("falloff", {}, -1);
  if (!(falloff > 0)) return;
  v1::Attenuation& attenuation = *light.mutable_attenuation();
  attenuation.set_scale(falloff);
  attenuation.set_quadratic(1);
  attenuation.set_distance(v1::Attenuation::PATH);
}

void make_point(CrtAttributes& in, v1::Light& light) {
  put(in.vector("origin"), light.mutable_point()->mutable_position());
  read_falloff(in, light);
}

void make_parallel(CrtAttributes& in, v1::Light& light) {
  constexpr double kDistance = 10000;  // occluders that are farther off cast no shadow
  put(way(in, "from", "pointing"), light.mutable_directional()->mutable_direction());
  light.set_shadow_distance(kDistance);
}

void make_spot(CrtAttributes& in, v1::Light& light) {
  v1::Light::Spot& spot = *light.mutable_spot();
  put(in.vector("origin"), spot.mutable_position());
  put(way(in, "origin", "pointing"), spot.mutable_direction());
  const double angle = in.number("angle", {.min = 0, .max = 180, .above_min = true});
  spot.set_cut_off(angle);
  spot.set_beam_width(in.number("beam", {.min = 0, .max = angle}, angle));
  read_falloff(in, light);
}

void make_cylinder(CrtAttributes& in, v1::Light& light) {
  v1::Light::Cylinder& cylinder = *light.mutable_cylinder();
  put(in.vector("origin"), cylinder.mutable_position());
  put(way(in, "origin", "pointing"), cylinder.mutable_direction());
  cylinder.set_beam_radius(in.number("radius", kCrtPositive));
  read_falloff(in, light);
}

}  // namespace

CrtValue make_crt_light(std::string_view name, CrtAttributes& in, CrtHeap& heap) {
  CrtLight made;
  v1::Light& light = made.message;
  if (name == "PointLight") {
    make_point(in, light);
  } else if (name == "ParallelLight") {
    make_parallel(in, light);
  } else if (name == "SpotLight") {
    make_spot(in, light);
  } else {
    make_cylinder(in, light);
  }
  put(in.color("color"), light.mutable_color());
  light.set_ambient_intensity(in.number("ambient", kCrtNotNegative, 0));
  if (!in.finish()) return CrtFailed{};
  return heap.add(std::move(made), in.where());
}

}  // namespace tessera
