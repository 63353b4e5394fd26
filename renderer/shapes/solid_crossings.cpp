// Sphere, box and plane as solids.
#include "renderer/math/rounding.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

namespace tessera {

bool Sphere::span(const Ray& ray, const RayError& error, SolidSpan& span) const {
  double t[2];
  const SphereLine line = line_of(ray);
  const Vec3& f = line.from;
  if (line.surely_misses(false) || !line.roots(t[0], t[1])) return false;
  const double places =
      l1_norm(center_ - Point3{}) + l1_norm(ray.origin - Point3{}) + l1_norm(f) + radius_;
  for (int i = 0; i < 2; ++i) {
    // For positive v the product |n| . v is at most the largest part of n times the sum of v's.
    const Vec3 n = ray.at(t[i]) - center_;
    const double depth = max_component(abs(n)) * (gamma(8) * places + l1_norm(error.origin) +
                                                  std::abs(t[i]) * l1_norm(error.direction));
    double reach = depth / std::abs(dot(n, ray.direction));
    // A tangent line is inside for no longer than the chord at the depth that is in doubt.
    if (!(reach * reach * dot(ray.direction, ray.direction) < depth)) {
      const double square = depth / radius_ * (2 * radius_ + depth / radius_);
      const double chord = 2 * std::sqrt(square) / length(ray.direction);
      reach = reach < chord ? reach : chord;
    }
    (i == 0 ? span.enter : span.leave) = {t[i], gamma(4) * std::abs(t[i]) + reach, i == 0};
  }
  return true;
}

bool Box::span(const Ray& ray, const RayError& error, SolidSpan& span) const {
  SolidEvent enter = SolidSpan{}.enter, leave = SolidSpan{}.leave;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0) {
      if (!(o >= extent_.min[axis] && o <= extent_.max[axis])) return false;
      continue;
    }
    const bool down = d < 0;
    const double t_in = ((down ? extent_.max[axis] : extent_.min[axis]) - o) / d;
    const double t_out = ((down ? extent_.min[axis] : extent_.max[axis]) - o) / d;
    const auto error_at = [&](double t) {
      const double own = gamma(3) * std::abs(t);
      const double given = error.origin[axis] + std::abs(t) * error.direction[axis];
      return given == 0 ? own : own + given / std::abs(d);
    };
    const auto face = static_cast<uint32_t>(2 * axis);
    if (t_in > enter.t) enter = {t_in, error_at(t_in), true, face + (down ? 1 : 0)};
    if (t_out < leave.t) leave = {t_out, error_at(t_out), false, face + (down ? 0 : 1)};
  }
  span = {enter, leave};
  return enter.t <= leave.t && enter.t != -Bounds3::kInfinity;
}

bool Plane::span(const Ray& ray, const RayError& error, SolidSpan& span) const {
  const Vec3& normal = equation_.normal;
  const double approach = dot(normal, ray.direction);
  const double height = signed_distance(ray.origin);
  span = {};
  if (approach == 0) return !(height > 0);
  const double t = -height / approach;
  const double own = distance_error(ray.origin);
  const double rounding = gamma(6) * std::abs(t) * dot(abs(normal), abs(ray.direction));
  const double reach =
      rounding / std::abs(approach) + crossing_depth(normal, t, error, own) / std::abs(approach);
  (approach < 0 ? span.enter : span.leave) = {t, reach, approach < 0};
  return true;
}

}  // namespace tessera
