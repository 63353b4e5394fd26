// Sphere, box and plane as solids.
#include "renderer/math/rounding.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

namespace tessera {
namespace {}  // namespace

void Sphere::crossings(const Ray& ray, const RayError& error,
                       std::vector<SolidEvent>& events) const {
  double t[2];
  const Vec3 f = ray.origin - center_;
  if (!roots(ray.direction, f, t[0], t[1])) return;
  const Vec3 size = abs(center_ - Point3{});
  const Vec3 from = abs(ray.origin - Point3{}) + abs(ray.origin - center_);
  const double speed = length(ray.direction);
  for (int i = 0; i < 2; ++i) {
    const Vec3 n = ray.at(t[i]) - center_;
    const double own = gamma(4) * (dot(abs(n), size + from) + radius_ * length(n));
    const double depth = crossing_depth(n, t[i], error, own);
    const double linear = depth / std::abs(dot(n, ray.direction));
    // A tangent line is inside for no longer than the chord at the depth that is in doubt.
    const double chord = 2 * std::sqrt(depth / radius_ * (2 * radius_ + depth / radius_)) / speed;
    events.push_back({t[i], gamma(4) * std::abs(t[i]) + (linear < chord ? linear : chord), i == 0});
  }
}

void Box::crossings(const Ray& ray, const RayError& error, std::vector<SolidEvent>& events) const {
  SolidEvent enter{-Bounds3::kInfinity, 0, true}, leave{Bounds3::kInfinity, 0, false};
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0) {
      if (!(o >= extent_.min[axis] && o <= extent_.max[axis])) return;
      continue;
    }
    const bool down = d < 0;
    const double t_in = ((down ? extent_.max[axis] : extent_.min[axis]) - o) / d;
    const double t_out = ((down ? extent_.min[axis] : extent_.max[axis]) - o) / d;
    const auto error_at = [&](double t) {
      return gamma(3) * std::abs(t) +
             (error.origin[axis] + std::abs(t) * error.direction[axis]) / std::abs(d);
    };
    const auto face = static_cast<uint32_t>(2 * axis);
    if (t_in > enter.t) enter = {t_in, error_at(t_in), true, face + (down ? 1 : 0)};
    if (t_out < leave.t) leave = {t_out, error_at(t_out), false, face + (down ? 0 : 1)};
  }
  if (!(enter.t <= leave.t) || enter.t == -Bounds3::kInfinity) return;
  events.push_back(enter);
  events.push_back(leave);
}

void Plane::crossings(const Ray& ray, const RayError& error,
                      std::vector<SolidEvent>& events) const {
  const Vec3 o = ray.origin - Point3{};
  const double approach = dot(normal_, ray.direction);
  const double height = dot(normal_, o) - offset_;
  SolidEvent crossing{0, 0, approach < 0};
  if (approach != 0) {
    crossing.t = -height / approach;
    const double own = gamma(4) * (dot(abs(normal_), abs(o)) + std::abs(offset_));
    crossing.error = gamma(6) * std::abs(crossing.t) * dot(abs(normal_), abs(ray.direction)) /
                         std::abs(approach) +
                     crossing_depth(normal_, crossing.t, error, own) / std::abs(approach);
    if (crossing.entering) events.push_back(crossing);
  } else if (height > 0) {
    return;
  }
  if (!crossing.entering || approach == 0) events.push_back({-Bounds3::kInfinity, 0, true});
  if (!crossing.entering && approach != 0)
    events.push_back(crossing);
  else
    events.push_back({Bounds3::kInfinity, 0, false});
}

}  // namespace tessera
