#include "renderer/shapes/torus.h"

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "renderer/math/quartic.h"
#include "renderer/math/rounding.h"
#include "renderer/math/transform.h"
#include "renderer/shapes/curved_sampler.h"
#include "renderer/shapes/outline_points.h"
#include "renderer/shapes/planar.h"

namespace tessera {
namespace {

constexpr double kTurn = 2 * portable::kPi;

Bounds3 box_of(double across, double up) { return {{-across, -up, -across}, {across, up, across}}; }

class TorusSampler final : public CurvedSampler {
 public:
  TorusSampler(double major, double minor, const Transform& to_world, bool flip)
      : CurvedSampler(kTurn * kTurn * major * minor, box_of(major + minor, minor), to_world, flip),
        major_(major),
        minor_(minor) {}

 private:
  CurvedPoint choose(const Vec2& u) const override {
    const double azimuth = kTurn * u.x, tube = tube_angle(kTurn * u.y);
    const double x = portable::cos(azimuth), z = portable::sin(azimuth);
    const double out = portable::cos(tube), up = portable::sin(tube);
    const double from_axis = major_ + minor_ * out;
    return {{from_axis * x, minor_ * up, from_axis * z}, {out * x, up, out * z}};
  }
  /// Of the equation a + e sin a = `share`, which has the tube's outside more often than its inside
  /// (Kepler's, from the other apsis); by halving, since Newton's steps may leave at e near 1.
  double tube_angle(double share) const {
    const double e = minor_ / major_;
    double low = 0, high = kTurn, a = share;
    for (int i = 0; i < 100 && low < high; ++i) {
      const double rest = a + e * portable::sin(a) - share;
      if (rest == 0) break;
      (rest > 0 ? high : low) = a;
      const double step = a - rest / (1 + e * portable::cos(a));
      const double next = step > low && step < high ? step : low + (high - low) / 2;
      if (std::abs(next - a) <= 0x1p-50 * kTurn) return next;
      a = next;
    }
    return a;
  }

  double major_, minor_;
};

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

bool Torus::centre_line(const Ray& ray, double radius, CentredLine& line) {
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

Torus::Stretch Torus::near_stretch(const CentredLine& line) const {
  // Inside the ball about the torus, grown by half, and between planes just above and below it:
  // both ends are outside of the torus by far more than rounding.
  const double ball = major_ + minor_;
  const double from_centre = length(line.p - Point3{});
  const double half =
      std::sqrt(std::max(0.0, (ball - from_centre) * (ball + from_centre))) + gamma(16) * ball;
  Stretch near{-1.5 * half - 0.001 * minor_, 1.5 * half + 0.001 * minor_};
  if (line.d.y != 0) {
    const double reach = 1.001 * minor_;
    const double x0 = (-reach - line.p.y) / line.d.y, x1 = (reach - line.p.y) / line.d.y;
    near.low = std::max(near.low, std::min(x0, x1));
    near.high = std::min(near.high, std::max(x0, x1));
  } else if (std::abs(line.p.y) > minor_) {
    near.high = near.low;
  }
  return near;
}

Torus::Slope Torus::slope_at(const CentredLine& line, double x) const {
  const Point3 at = line.p + line.d * x;
  const double rho = std::sqrt(at.x * at.x + at.z * at.z);
  Slope s;
  // How the distance from the axis changes, and how that does.
  s.rise = rho > 0 ? (at.x * line.d.x + at.z * line.d.z) / rho : 0;
  s.bend = rho > 0 ? (line.d.x * line.d.x + line.d.z * line.d.z - s.rise * s.rise) / rho : 0;
  const double ring = rho - major_;
  const double from_circle = std::sqrt(ring * ring + at.y * at.y);
  s.distance = from_circle - minor_;
  s.change = from_circle > 0 ? (ring * s.rise + at.y * line.d.y) / from_circle : 0;
  return s;
}

void Torus::sharpen_turn(const CentredLine& line, bool is_minimum, const Stretch& between,
                         End& turn) const {
  // With g the squared distance from the circle, g' = 2 (x - R rho') and g'' = 2 (1 - R rho'').
  const Slope s = slope_at(line, turn.x);
  const double curve = 1 - major_ * s.bend;
  if ((curve > 0) != is_minimum) return;
  const double along = accurate_dot(line.d, line.p - Point3{}) + turn.x;
  const double moved = turn.x - (along - major_ * s.rise) / curve;
  if (!(moved > between.low && moved < between.high)) return;
  const double distance = slope_at(line, moved).distance;
  if (is_minimum ? distance < turn.distance : distance > turn.distance) turn = {moved, distance};
}

int Torus::find_ends(const CentredLine& line, const Stretch& near, std::array<End, 6>& ends) const {
  // Half the derivative of the quartic x^4 + 2 (k - 2 R^2 a) x^2 - 8 R^2 b x + ..., where a and b
  // are of the squared distance a x^2 + 2 b x + c from the axis.
  const Vec3 p = line.p - Point3{};
  const double a = line.d.x * line.d.x + line.d.z * line.d.z;
  const double b = p.x * line.d.x + p.z * line.d.z;
  const double k = dot(p, p) + (major_ - minor_) * (major_ + minor_);
  const double r2 = major_ * major_;
  const Polynomial<3> slope{-4 * r2 * b, 2 * (k - 2 * r2 * a), 0, 2};
  std::array<double, 3> turns;
  const int turn_count = roots_between<3>(slope, near.low, near.high, turns);
  int count = 0;
  ends[count++] = {near.low, minor_};
  for (int i = 0; i < turn_count; ++i) {
    End turn{turns[static_cast<size_t>(i)], 0};
    turn.distance = slope_at(line, turn.x).distance;
    // Near a tangent the quartic turns where the distance does, but not as exactly.
    if (std::abs(turn.distance) < 0.01 * minor_) {
      const double next = i + 1 < turn_count ? turns[static_cast<size_t>(i) + 1] : near.high;
      const bool is_minimum = slope[1] + 6 * turn.x * turn.x > 0;
      sharpen_turn(line, is_minimum, {ends[static_cast<size_t>(count - 1)].x, next}, turn);
    }
    if (turn.x > ends[static_cast<size_t>(count - 1)].x) ends[static_cast<size_t>(count++)] = turn;
  }
  ends[static_cast<size_t>(count++)] = {near.high, minor_};
  return count;
}

Torus::Roots Torus::find_roots(const Ray& ray) const {
  Roots roots;
  CentredLine line;
  if (!centre_line(ray, major_ + minor_, line)) return roots;
  const Stretch near = near_stretch(line);
  if (!(near.low < near.high)) return roots;
  std::array<End, 6> ends;
  int count = find_ends(line, near, ends);
  // The origin's side is told by its own distance: a root beyond it is ahead, however near.
  const bool split = line.at_origin > near.low && line.at_origin < near.high;
  if (split) {
    const auto end = ends.begin() + count;
    const auto after =
        std::find_if(ends.begin(), end, [&](const End& e) { return e.x > line.at_origin; });
    std::copy_backward(after, end, end + 1);
    *after = {line.at_origin, slope_at({ray.origin, {}, 0, 0}, 0).distance};
    ++count;
  }
  for (size_t i = 1; i < static_cast<size_t>(count); ++i) {
    const bool outside = ends[i - 1].distance > 0;
    if (outside == (ends[i].distance > 0)) continue;
    const double x = bracketed_root(ends[i - 1].x, ends[i].x, !outside, [&](double at) {
      const Slope s = slope_at(line, at);
      return std::pair{s.distance, s.change};
    });
    double t = (x - line.at_origin) / line.speed;
    if (split && ends[i - 1].x >= line.at_origin) t = std::max(t, next_up(0.0));
    if (split && ends[i].x <= line.at_origin) t = std::min(t, 0.0);
    roots.t[static_cast<size_t>(roots.count++)] = t;
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

std::unique_ptr<const SurfaceSampler> Torus::make_sampler(const Transform& world_from_object,
                                                          bool flip_normals) const {
  if (minor_ > major_) return nullptr;
  return std::make_unique<TorusSampler>(major_, minor_, world_from_object, flip_normals);
}

std::vector<Point3> Torus::outline() const {
  const Vec3 half = bounds().diagonal() * .5;
  std::vector<Point3> points;
  for (int i = 0; i <= 2 * kRimSteps; ++i) {
    add_rim(half.x - half.y + half.y * portable::cos(i * kRimStep),
            half.y * portable::sin(i * kRimStep), points);
  }
  return points;
}

}  // namespace tessera
