#include "renderer/shapes/torus.h"

#include "base/error.h"
#include "renderer/math/accurate_dot.h"
#include "renderer/math/elementary.h"
#include "renderer/math/quartic.h"
#include "renderer/shapes/planar.h"

namespace tessera {
namespace {

/// The line as p + x d with d of unit length and p nearest to the centre.
struct CentredLine {
  Point3 p;
  Vec3 d;
  double speed = 0;      ///< length of the ray's direction
  double at_origin = 0;  ///< x at the ray's origin
};

/// False where the line misses the ball of `radius` or has no direction.
bool centre_line(const Ray& ray, double radius, CentredLine& line) {
  const Vec3& d = ray.direction;
  line.speed = length(d);
  if (!(line.speed > 0 && std::isfinite(line.speed))) return false;
  line.d = d / line.speed;
  const Vec3 o = ray.origin - Point3{};
  const Vec3 moment = accurate_cross(o, d);
  const double moment_length = length(moment);
  if (!(moment_length <= radius * line.speed * (1 + gamma(16)))) return false;
  line.p = Point3{} + accurate_cross(d, moment) / dot(d, d);
  line.at_origin = accurate_dot(o, d) / line.speed;
  return true;
}

}  // namespace

Torus::Torus(double major_radius, double minor_radius)
    : major_(major_radius), minor_(minor_radius) {
  if (!(major_ > 0 && minor_ > 0 && std::isfinite(major_ + minor_)))
    throw scene_error("a torus's radius is wrong; expected two numbers > 0");
}

Bounds3 Torus::bounds() const {
  const double reach = next_up((major_ + minor_) * (1 + gamma(12)));
  const double height = next_up(minor_ * (1 + gamma(12)));
  return {{-reach, -height, -reach}, {reach, height, reach}};
}

double Torus::signed_distance(double x, double y, double z) const {
  const double ring = std::sqrt(x * x + z * z) - major_;
  return std::sqrt(ring * ring + y * y) - minor_;
}

Torus::Roots Torus::find_roots(const Ray& ray) const {
  Roots roots;
  CentredLine line;
  const double ball = major_ + minor_;
  if (!centre_line(ray, ball, line)) return roots;
  const Point3& p = line.p;
  const Vec3& d = line.d;
  const auto distance_at = [&](double x) {
    return signed_distance(p.x + x * d.x, p.y + x * d.y, p.z + x * d.z);
  };
  // Where the line is inside the ball about the torus and between the planes above and below it.
  const double m2 = dot(p - Point3{}, p - Point3{});
  double high =
      std::sqrt(std::max(0.0, (ball - std::sqrt(m2)) * (ball + std::sqrt(m2)))) + gamma(16) * ball;
  // Grown by half, so that both ends are well outside of the torus.
  high = 1.5 * high + 0.001 * minor_;
  double low = -high;
  if (d.y != 0) {
    const double reach = 1.001 * minor_;
    const double x0 = (-reach - p.y) / d.y, x1 = (reach - p.y) / d.y;
    low = std::max(low, std::min(x0, x1));
    high = std::min(high, std::max(x0, x1));
  }
  if (!((d.y != 0 || std::abs(p.y) <= minor_) && low < high)) return roots;
  // Half the derivative of the quartic: x^4 + 2 (k - 2 R^2 a) x^2 - 8 R^2 b x + ..., where a, b are
  // of the squared distance a x^2 + 2 b x + c from the axis.
  const double a = d.x * d.x + d.z * d.z;
  const double b = p.x * d.x + p.z * d.z;
  const double k = m2 + (major_ - minor_) * (major_ + minor_);
  const double r2 = major_ * major_;
  const Polynomial<3> slope{-4 * r2 * b, 2 * (k - 2 * r2 * a), 0, 2};
  std::array<double, 3> turns;
  const int turn_count = roots_between<3>(slope, low, high, turns);
  // Newton's step to where the distance itself turns, which near a tangent is the same place.
  const auto ring_slope = [&](double x) {
    const double rho =
        std::sqrt((p.x + x * d.x) * (p.x + x * d.x) + (p.z + x * d.z) * (p.z + x * d.z));
    return std::pair{rho, rho > 0 ? (b + a * x) / rho : 0.0};
  };
  struct End {
    double x, distance;
  };
  std::array<End, 6> ends;
  int end_count = 0;
  const auto add_end = [&](double x, double distance) { ends[end_count++] = {x, distance}; };
  const bool split = line.at_origin > low && line.at_origin < high;
  bool origin_added = !split;
  const double origin_distance =
      split ? signed_distance(ray.origin.x, ray.origin.y, ray.origin.z) : 0;
  add_end(low, minor_);
  for (int i = 0; i <= turn_count; ++i) {
    double x = i < turn_count ? turns[i] : high;
    double distance = i < turn_count ? distance_at(x) : minor_;
    if (i < turn_count && std::abs(distance) < 0.01 * minor_) {
      // With g the squared distance from the circle: g' = 2 (x - R rho'), g'' = 2 (1 - R rho'').
      const auto [rho, rise] = ring_slope(x);
      const double bend = rho > 0 ? (a - rise * rise) / rho : 0;
      const double curve = 1 - major_ * bend;
      const double moved =
          x - (accurate_dot({d.x, d.y, d.z}, {p.x, p.y, p.z}) + x - major_ * rise) / curve;
      if (moved > ends[end_count - 1].x && moved < (i + 1 < turn_count ? turns[i + 1] : high)) {
        const double better = distance_at(moved);
        if (curve > 0 ? better < distance : better > distance) x = moved, distance = better;
      }
    }
    if (!origin_added && line.at_origin < x) {
      add_end(line.at_origin, origin_distance);
      origin_added = true;
    }
    if (x > ends[end_count - 1].x || i == turn_count) add_end(x, distance);
  }
  for (int i = 1; i < end_count; ++i) {
    const bool outside = ends[i - 1].distance > 0;
    if (outside == (ends[i].distance > 0)) continue;
    const double x = bracketed_root(ends[i - 1].x, ends[i].x, !outside, [&](double at) {
      const auto [rho, rise] = ring_slope(at);
      const double ring = rho - major_, y = p.y + at * d.y;
      const double distance = std::sqrt(ring * ring + y * y);
      return std::pair{distance - minor_, distance > 0 ? (ring * rise + y * d.y) / distance : 0.0};
    });
    double t = (x - line.at_origin) / line.speed;
    // The origin's side was told by its own distance: a root beyond it is ahead, however near.
    if (split) {
      if (ends[i - 1].x >= line.at_origin) t = std::max(t, next_up(0.0));
      if (ends[i].x <= line.at_origin) t = std::min(t, 0.0);
    }
    roots.t[roots.count++] = t;
  }
  return roots;
}

bool Torus::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  const Roots roots = find_roots(ray);
  for (int i = 0; i < roots.count; ++i) {
    // Entering shows the front, leaving the back.
    if (ray.cull == (i % 2 == 0 ? Cull::front : Cull::back)) continue;
    const double t = roots.t[i];
    if (!(t > ray.t_min && t < ray.t_max)) continue;
    if (t > hit.t || (t == hit.t && hit.primitive == 0)) return false;
    hit = {t, 0, 0, hit.instance, 0};
    return true;
  }
  return false;
}

bool Torus::any_hit(const Ray& ray, TraversalCounters& counters) const {
  Hit hit;
  return closest_hit(ray, hit, counters);
}

void Torus::crossings(const Ray& ray, const RayError& error,
                      std::vector<SolidEvent>& events) const {
  const Roots roots = find_roots(ray);
  const double speed = length(ray.direction);
  for (int i = 0; i < roots.count; ++i) {
    const double t = roots.t[i];
    const Vec3 n = static_cast<Vec3>(surface(ray, {t}).geometric_normal);
    const double own = gamma(8) * (major_ + minor_);
    const double depth = crossing_depth(n, t, error, own);
    const double linear = depth / std::abs(dot(n, ray.direction));
    // Where the line touches, up to the fourth order, it is near the surface no longer than this.
    const double scale = major_ + minor_;
    const double touch = 4 * scale * std::sqrt(std::sqrt(depth / scale)) / speed;
    events.push_back({t, gamma(3) * std::abs(t) + (linear < touch ? linear : touch), i % 2 == 0});
  }
}

LocalSurface Torus::surface(const Ray& ray, const Hit& hit) const {
  using namespace portable;
  LocalSurface s;
  const Point3 near_surface = ray.at(hit.t);
  const double rho = std::sqrt(near_surface.x * near_surface.x + near_surface.z * near_surface.z);
  const Vec3 out = rho > 0 ? Vec3{near_surface.x / rho, 0, near_surface.z / rho} : Vec3{1, 0, 0};
  Vec3 tube{rho - major_, near_surface.y, 0};  // in the plane through the axis and the point
  tube = tube == Vec3{} ? Vec3{1, 0, 0} : normalize(tube);
  const Vec3 n{out.x * tube.x, tube.y, out.z * tube.x};
  const double from_axis = major_ + minor_ * tube.x;
  s.point = {out.x * from_axis, minor_ * tube.y, out.z * from_axis};
  for (int axis = 0; axis < 3; ++axis)
    s.point_error[axis] = gamma(8) * (major_ * std::abs(out[axis]) + minor_ * std::abs(n[axis]));
  s.geometric_normal = s.shading_normal = to_normal(n);
  s.uv = {0.5 + atan2(out.x, out.z) / (2 * kPi), 0.5 + atan2(tube.y, tube.x) / (2 * kPi)};
  s.dpdu = Vec3{s.point.z, 0, -s.point.x} * (2 * kPi);
  s.dpdv = Vec3{-out.x * tube.y, tube.x, -out.z * tube.y} * (2 * kPi * minor_);
  return s;
}

}  // namespace tessera
