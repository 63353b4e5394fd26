#include "renderer/shapes/frustum.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "renderer/math/rounding.h"
#include "renderer/math/warp.h"
#include "renderer/shapes/curved_sampler.h"
#include "renderer/shapes/outline_points.h"

namespace tessera {
namespace {

/// The unit direction of p across the axis; +x on the axis itself.
Vec3 outward(const Point3& p) {
  const double r = std::sqrt(p.x * p.x + p.z * p.z);
  if (!(r > 0)) return {1, 0, 0};
  return {p.x / r, 0, p.z / r};
}

constexpr double kTurn = 2 * portable::kPi;

/// What it is made of.
struct FrustumParts {
  double bottom_radius = 0, top_radius = 0, half_height = 0;
  OpenParts open;
};

class FrustumSampler final : public CurvedSampler {
 public:
  FrustumSampler(const FrustumParts& parts, const Transform& to_world, bool flip)
      : CurvedSampler(area_of(parts), box_of(parts), to_world, flip), parts_(parts) {}
  static double area_of(const FrustumParts& parts) {
    return side_area(parts) + top_area(parts) + bottom_area(parts);
  }

 private:
  static Bounds3 box_of(const FrustumParts& p) {
    const double across = std::max(p.bottom_radius, p.top_radius);
    return {{-across, -p.half_height, -across}, {across, p.half_height, across}};
  }
  static double slant(const FrustumParts& p) {
    return std::hypot(2 * p.half_height, p.bottom_radius - p.top_radius);
  }
  static double side_area(const FrustumParts& p) {
    return p.open.side ? 0 : kTurn / 2 * (p.bottom_radius + p.top_radius) * slant(p);
  }
  static double top_area(const FrustumParts& p) {
    return p.open.top ? 0 : kTurn / 2 * p.top_radius * p.top_radius;
  }
  static double bottom_area(const FrustumParts& p) {
    return p.open.bottom ? 0 : kTurn / 2 * p.bottom_radius * p.bottom_radius;
  }
  CurvedPoint choose(const Vec2& u) const override {
    double at = u.x * area_of(parts_);
    const auto is_in = [&](double area) {
      if (at < area) {
        at = std::min(at / area, 0x1.fffffffffffffp-1);
        return true;
      }
      at -= area;
      return false;
    };
    if (is_in(side_area(parts_))) return on_side({at, u.y});
    if (is_in(top_area(parts_))) return on_cap({at, u.y}, parts_.top_radius, 1);
    if (is_in(bottom_area(parts_))) return on_cap({at, u.y}, parts_.bottom_radius, -1);
    return parts_.open.side ? on_cap(u, parts_.open.top ? parts_.bottom_radius : parts_.top_radius,
                                     parts_.open.top ? -1 : 1)
                            : on_side(u);  // past the last by rounding
  }
  /// As many points at each height as its circle is long.
  CurvedPoint on_side(const Vec2& u) const {
    const double r0 = parts_.bottom_radius, r1 = parts_.top_radius;
    const double radius = std::sqrt(r0 * r0 + u.x * (r1 * r1 - r0 * r0));
    // The share of the height.
    const double up = r0 + radius > 0 ? u.x * (r0 + r1) / (r0 + radius) : 0;
    const double azimuth = kTurn * u.y;
    const double x = portable::cos(azimuth), z = portable::sin(azimuth);
    const double height = 2 * parts_.half_height, along = height / slant(parts_);
    return {{radius * x, parts_.half_height * (2 * up - 1), radius * z},
            {along * x, (r0 - r1) / slant(parts_), along * z}};
  }
  CurvedPoint on_cap(const Vec2& u, double radius, double side) const {
    const Vec2 d = disc_point(u);
    return {{radius * d.x, side * parts_.half_height, radius * d.y}, {0, side, 0}};
  }

  FrustumParts parts_;
};

}  // namespace

Frustum::Frustum(double bottom_radius, double top_radius, double height, const OpenParts& open)
    : bottom_radius_(bottom_radius),
      top_radius_(top_radius),
      half_height_(0.5 * height),
      mean_radius_(0.5 * (bottom_radius + top_radius)),
      slope_((top_radius - bottom_radius) / height),
      open_(open) {
  if (!(height > 0 && std::isfinite(height) && bottom_radius >= 0 && top_radius >= 0 &&
        mean_radius_ > 0 && std::isfinite(mean_radius_) && std::isfinite(slope_)))
    throw scene_error("a cylinder's or cone's radius or height is wrong; expected numbers > 0");
  mean_radius_low_ = 0.5 * two_sum(bottom_radius, top_radius).low;
  const DoubleDouble widening = two_sum(top_radius, -bottom_radius);
  const DoubleDouble product = two_product(slope_, height);
  slope_low_ = ((widening.high - product.high) - product.low + widening.low) / height;
}

Bounds3 Frustum::bounds() const {
  const double reach = next_up(std::max(bottom_radius_, top_radius_) * (1 + gamma(8)));
  return {{-reach, -half_height_, -reach}, {reach, half_height_, reach}};
}

bool Frustum::is_open(Part part) const {
  return part == kSide ? open_.side : part == kTop ? open_.top : open_.bottom;
}

bool Frustum::cross_side(const Point3& o, const Vec3& d, Stretch& inside) const {
  // Only how the line moves across the axis and the radius grows counts, whose squares must not
  // underflow.
  const double across = std::max({std::abs(d.x), std::abs(d.z), std::abs(slope_ * d.y)});
  if (across < 0x1p-480 && across > 0) [[unlikely]] {
    const int exponent = std::ilogb(across);
    const double along = slope_ == 0 ? 0 : std::ldexp(d.y, -exponent);
    const Vec3 scaled{std::ldexp(d.x, -exponent), along, std::ldexp(d.z, -exponent)};
    if (!cross_side(o, scaled, inside)) return false;
    for (double* t : {&inside.enter, &inside.leave}) *t = std::ldexp(*t, -exponent);
    return true;
  }
  // a t^2 + 2 b t + c is the squared distance from the axis less the squared radius there, which is
  // radius + grow t. Both are sums of two doubles: their products cancel far from the solid.
  const auto widening = [this](double y) {
    const DoubleDouble product = two_product(slope_, y);
    return fast_two_sum(product.high, product.low + slope_low_ * y);
  };
  const DoubleDouble k = widening(o.y), grow = widening(d.y);
  const DoubleDouble sum = two_sum(mean_radius_, k.high);
  const DoubleDouble radius = fast_two_sum(sum.high, sum.low + (k.low + mean_radius_low_));
  const double a =
      accurate_dot({d.x, d.z, -grow.high, -2 * grow.high}, {d.x, d.z, grow.high, grow.low});
  const double b = accurate_dot({o.x, o.z, -radius.high, -radius.high, -radius.low},
                                {d.x, d.z, grow.high, grow.low, grow.high});
  const double c =
      accurate_dot({o.x, o.z, -radius.high, -2 * radius.high}, {o.x, o.z, radius.high, radius.low});
  // b^2 - a c by the line's moments about the origin, as small as its distance from there, or as it
  // stands: whichever cancels less. For an origin inside of a > 0 nothing cancels.
  const double wx =
      accurate_dot({d.x, d.x, -o.x, -o.x}, {radius.high, radius.low, grow.high, grow.low});
  const double wz =
      accurate_dot({d.z, d.z, -o.z, -o.z}, {radius.high, radius.low, grow.high, grow.low});
  const double w2 = wx * wx + wz * wz;
  double discriminant;
  if ((a > 0 && c < 0) || b * b + std::abs(a * c) < w2) {
    discriminant = b * b - a * c;
  } else {
    const double w = std::sqrt(w2);
    const double axial = std::abs(difference_of_products(o.x, d.z, o.z, d.x));
    discriminant = (w + axial) * (w - axial);
  }
  if (!(discriminant >= 0)) {
    if (a >= 0) return false;
    discriminant = 0;
  }
  if (!std::isfinite(a + b + c)) return false;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  if (a == 0 && b == 0) {
    if (c > 0) return false;
    inside = {-Bounds3::kInfinity, Bounds3::kInfinity};
    return true;
  }
  // Where q is 0 so are b and the discriminant, and c or a: the double root 0.
  const double t0 = q == 0 ? 0 : c / q, t1 = q == 0 ? 0 : q / a;
  if (a > 0)
    inside = {std::min(t0, t1), std::max(t0, t1)};
  else if (grow.high > 0)
    inside = {a == 0 ? t0 : std::max(t0, t1), Bounds3::kInfinity};
  else
    inside = {-Bounds3::kInfinity, a == 0 ? t0 : std::min(t0, t1)};
  return true;
}

bool Frustum::cross(const Ray& ray, Crossing& enter, Crossing& leave) const {
  const double o = ray.origin.y, d = ray.direction.y;
  enter = {-Bounds3::kInfinity, kTop};
  leave = {Bounds3::kInfinity, kTop};
  if (d == 0) {
    if (!(std::abs(o) <= half_height_)) return false;
  } else {
    const double top = (half_height_ - o) / d, bottom = (-half_height_ - o) / d;
    enter = d < 0 ? Crossing{top, kTop} : Crossing{bottom, kBottom};
    leave = d < 0 ? Crossing{bottom, kBottom} : Crossing{top, kTop};
  }
  Stretch side;
  if (!cross_side(ray.origin, ray.direction, side)) return false;
  // A cap of no radius is the apex, which belongs to the side.
  const auto is_point = [this](Part part) {
    return (part == kTop ? top_radius_ : bottom_radius_) == 0;
  };
  if (side.enter >= enter.t)
    enter = {side.enter, kSide};
  else if (is_point(enter.part))
    enter.part = kSide;
  if (side.leave <= leave.t)
    leave = {side.leave, kSide};
  else if (is_point(leave.part))
    leave.part = kSide;
  // A line without direction, or with a part that is not finite, has no finite ends.
  return enter.t <= leave.t && enter.t > -Bounds3::kInfinity && leave.t < Bounds3::kInfinity;
}

bool Frustum::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  Crossing crossings[2];
  if (!cross(ray, crossings[0], crossings[1])) return false;
  for (int i = 0; i < 2; ++i) {
    // Entering shows the front, leaving the back.
    if (ray.cull == (i == 0 ? Cull::front : Cull::back)) continue;
    const Crossing& at = crossings[i];
    if (is_open(at.part) || !(at.t > ray.t_min && at.t < ray.t_max)) continue;
    if (at.t > hit.t || (at.t == hit.t && at.part >= hit.primitive)) return false;
    hit = {at.t, 0, 0, hit.instance, at.part};
    return true;
  }
  return false;
}

double Frustum::event_error(const Ray& ray, const Crossing& at, const RayError& error) const {
  const double rounding = gamma(3) * std::abs(at.t);
  if (at.part != kSide)
    return rounding + crossing_depth({0, 1, 0}, at.t, error, gamma(2) * half_height_) /
                          std::abs(ray.direction.y);
  const Point3 p = ray.at(at.t);
  Vec3 n = outward(p);
  n.y = -slope_;
  const double distance = gamma(8) * (mean_radius_ + std::abs(slope_) * half_height_);
  const double depth = crossing_depth(n, at.t, error, distance);
  const double linear = depth / std::abs(dot(n, ray.direction));
  // A tangent line is inside for no longer than the chord at the depth that is in doubt.
  const double across =
      std::sqrt(ray.direction.x * ray.direction.x + ray.direction.z * ray.direction.z);
  const double chord =
      2 * std::sqrt(2 * (depth + std::max(bottom_radius_, top_radius_)) * depth) / across;
  return rounding + std::min(linear, chord);
}

bool Frustum::span(const Ray& ray, const RayError& error, SolidSpan& span) const {
  Crossing enter, leave;
  if (!cross(ray, enter, leave)) return false;
  span.enter = {enter.t, event_error(ray, enter, error), true, enter.part};
  span.leave = {leave.t, event_error(ray, leave, error), false, leave.part};
  return true;
}

void Frustum::side_surface(const Point3& near_side, LocalSurface& s) const {
  using namespace portable;
  const double y = std::min(std::max(near_side.y, -half_height_), half_height_);
  const double r = radius_at(y);
  const Vec3 out = outward(near_side);
  s.point = {out.x * r, y, out.z * r};
  const double radius_error =
      gamma(8) * std::abs(r) + gamma(4) * (mean_radius_ + std::abs(slope_ * y));
  s.point_error = {std::abs(out.x) * radius_error, kUnitRoundoff * std::abs(y),
                   std::abs(out.z) * radius_error};
  s.geometric_normal = s.shading_normal = to_normal(normalize(Vec3{out.x, -slope_, out.z}));
  s.uv = {0.5 + atan2(out.x, out.z) / (2 * kPi), 0.5 + y / (2 * half_height_)};
  s.dpdu = Vec3{s.point.z, 0, -s.point.x} * (2 * kPi);
  s.dpdv = Vec3{slope_ * out.x, 1, slope_ * out.z} * (2 * half_height_);
}

void Frustum::cap_surface(const Point3& near_cap, bool top, LocalSurface& s) const {
  const double r = top ? top_radius_ : bottom_radius_;
  const double sign = top ? 1 : -1;
  s.point = {near_cap.x, sign * half_height_, near_cap.z};
  s.point_error = {gamma(3) * std::abs(near_cap.x), 0, gamma(3) * std::abs(near_cap.z)};
  s.geometric_normal = s.shading_normal = {0, sign, 0};
  s.uv = {0.5 + near_cap.x / (2 * r), 0.5 - sign * near_cap.z / (2 * r)};
  s.dpdu = {2 * r, 0, 0};
  s.dpdv = {0, 0, -sign * 2 * r};
}

LocalSurface Frustum::surface(const Ray& ray, const Hit& hit) const {
  LocalSurface s;
  if (hit.primitive == kSide)
    side_surface(ray.at(hit.t), s);
  else
    cap_surface(ray.at(hit.t), hit.primitive == kTop, s);
  return s;
}

std::unique_ptr<const SurfaceSampler> Frustum::make_sampler(const Transform& world_from_object,
                                                            bool flip_normals) const {
  const FrustumParts parts{bottom_radius_, top_radius_, half_height_, open_};
  if (!(FrustumSampler::area_of(parts) > 0)) return nullptr;
  return std::make_unique<FrustumSampler>(parts, world_from_object, flip_normals);
}

std::vector<Point3> Frustum::outline() const {
  const Bounds3 box = bounds();
  std::vector<Point3> points;
  add_rim(bottom_radius_, box.min.y, points);
  add_rim(top_radius_, box.max.y, points);
  return points;
}

}  // namespace tessera
