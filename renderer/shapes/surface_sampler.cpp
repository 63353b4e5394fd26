#include "renderer/shapes/surface_sampler.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/frame.h"
#include "renderer/math/warp.h"
#include "renderer/shapes/area_density.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/curved_sampler.h"
#include "renderer/shapes/disc.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/spherical_rectangle.h"
#include "renderer/shapes/torus.h"
#include "renderer/shapes/triangle_sampler.h"

namespace tessera {

namespace {

/// Spread evenly: each kind gives its points.
class AreaSampler : public SurfaceSampler {
 public:
  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override {
    choose(u, sample);
    return density_by_area(area(), from.at, sample.point, sample.normal);
  }
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t) const override {
    return density_by_area(area(), from.at, there, normal);
  }

 private:
  virtual void choose(const Vec2& u, SurfaceSample& sample) const = 0;
};

class SphereSampler final : public SurfaceSampler {
 public:
  SphereSampler(const Point3& center, double radius, bool flip)
      : center_(center), radius_(radius), side_(flip ? -1 : 1) {}

  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override {
    const Vec3 way = center_ - from.at;
    const double squared = length_squared(way);
    if (!is_outside(squared)) {  // evenly
      place(direction_at(1 - 2 * u.x, u.y), sample);
      return density_by_area(area(), from.at, sample.point, sample.normal);
    }
    const double sin2 = radius_ * radius_ / squared;
    const double from_axis = one_minus_cosine(sin2);  // exact for the smallest of cones too
    const double drop = u.x * from_axis, cos_chosen = 1 - drop;
    const double sin2_chosen = drop * (2 - drop);
    // The angle at the centre between the axis and the chosen point (PBRT 4ed, 6.2.4).
    const double along = sin2_chosen / std::sqrt(sin2) +
                         cos_chosen * std::sqrt(std::max(0.0, 1 - sin2_chosen / sin2));
    const Vec3 local = direction_at(std::min(along, 1.0), u.y);
    place(Frame(-way / std::sqrt(squared)).from_local(local), sample);
    return 1 / (2 * portable::kPi * from_axis);
  }
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t) const override {
    const double squared = length_squared(center_ - from.at);
    if (!is_outside(squared)) return density_by_area(area(), from.at, there, normal);
    if (dot(there - from.at, there - center_) > 0) return 0;  // the half that looks away
    return 1 / (2 * portable::kPi * one_minus_cosine(radius_ * radius_ / squared));
  }
  double area() const override { return 4 * portable::kPi * radius_ * radius_; }
  Bounds3 bounds() const override {
    const Vec3 r{radius_, radius_, radius_};
    return {center_ - r, center_ + r};
  }

 private:
  /// Clearly: on the sphere itself, rounding would decide which half of it is seen.
  bool is_outside(double squared) const { return squared > radius_ * radius_ * (1 + 0x1p-20); }
  static double one_minus_cosine(double sin2) { return sin2 / (1 + std::sqrt(1 - sin2)); }
  void place(const Vec3& out, SurfaceSample& sample) const {
    sample.point = center_ + out * radius_;
    sample.point_error = rounding_of(sample.point, radius_);
    sample.normal = out * side_;
  }

  Point3 center_;
  double radius_, side_;
};

class DiscSampler final : public AreaSampler {
 public:
  /// `a` and `b` lead from the centre to the rim, square to each other before any transform.
  DiscSampler(const Point3& center, const Vec3& a, const Vec3& b, double inner, const Vec3& normal)
      : center_(center), a_(a), b_(b), inner_(inner), normal_(normal) {}
  double area() const override {
    return portable::kPi * length(cross(a_, b_)) * (1 - inner_ * inner_);
  }
  Bounds3 bounds() const override {
    const Vec3 r = abs(a_) + abs(b_);
    return {center_ - r, center_ + r};
  }
  bool is_flat(Point3& at, Vec3& normal) const override {
    at = center_;
    normal = normal_;
    return true;
  }

 private:
  void choose(const Vec2& u, SurfaceSample& sample) const override {
    Vec2 d = disc_point(u);
    if (inner_ > 0) {
      const double r2 = d.x * d.x + d.y * d.y;
      if (r2 == 0) d = {1e-150, 0};
      const double from = std::sqrt(d.x * d.x + d.y * d.y);
      const double to = std::sqrt(inner_ * inner_ + (1 - inner_ * inner_) * r2);
      d = {d.x * (to / from), d.y * (to / from)};
    }
    sample.point = center_ + a_ * d.x + b_ * d.y;
    sample.point_error = rounding_of(sample.point, length(a_) + length(b_));
    sample.normal = normal_;
  }

  Point3 center_;
  Vec3 a_, b_;
  double inner_;
  Vec3 normal_;
};

/// Points of [0, 1], with a density that goes in a line from one end to the other.
class LinearDensity {
 public:
  /// In the ratio of `from` to `to`; evenly where these are no numbers above 0.
  LinearDensity(double from, double to) {
    const double sum = from + to;
    if (sum > 1e-140 && sum < 1e140) from_ = from, to_ = to;
  }
  double at(double t) const { return 2 * (from_ + t * (to_ - from_)) / (from_ + to_); }
  double point(double u) const {
    const double root = std::sqrt(from_ * from_ + u * (to_ * to_ - from_ * from_));
    return std::min(u * (from_ + to_) / (from_ + root), 0x1.fffffffffffffp-1);
  }

 private:
  double from_ = 1, to_ = 1;
};

class RectangleSampler final : public SurfaceSampler {
 public:
  RectangleSampler(const Point3& corner, const Vec3& a, const Vec3& b, const Vec3& normal)
      : corner_(corner),
        center_(corner + (a + b) * 0.5),
        a_(a),
        b_(b),
        normal_(normal),
        area_(length(cross(a, b))),
        reach_(length(a) + length(b)) {
    const Vec3 across = cross(a, b);
    share_a_ = cross(b, across) / length_squared(across);
    share_b_ = cross(across, a) / length_squared(across);
    // Far away, its small solid angle loses digits.
    constexpr double kFar = 2;
    const bool is_square = std::abs(dot(a, b)) <= 1e-12 * length(a) * length(b);
    near_ = is_square ? kFar * area_ : 0;
  }
  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override {
    if (!is_near(from.at)) {
      const Seen seen = seen_from(from.at);
      const Vec2 at{seen.a.point(u.x), seen.b.point(u.y)};
      place(corner_ + a_ * at.x + b_ * at.y, sample);
      return density_by_area(area_, from.at, sample.point, sample.normal) * seen.density(at);
    }
    const SphericalRectangle seen(corner_, a_, b_, from.at);
    if (!(seen.solid_angle() > 0)) return 0;
    place(seen.point(u), sample);
    return 1 / seen.solid_angle();
  }
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t) const override {
    if (!is_near(from.at)) {
      const Vec3 way = there - corner_;
      const auto inside = [](double share) { return std::min(std::max(share, 0.0), 1.0); };
      const Vec2 at{inside(dot(way, share_a_)), inside(dot(way, share_b_))};
      return density_by_area(area_, from.at, there, normal) * seen_from(from.at).density(at);
    }
    const double angle = SphericalRectangle(corner_, a_, b_, from.at).solid_angle();
    return angle > 0 ? 1 / angle : 0;
  }
  double area() const override { return area_; }
  bool is_flat(Point3& at, Vec3& normal) const override {
    at = corner_;
    normal = normal_;
    return true;
  }
  Bounds3 bounds() const override {
    Bounds3 box;
    for (const Point3& p : {corner_, corner_ + a_, corner_ + b_, corner_ + a_ + b_}) box.extend(p);
    return box;
  }

 private:
  bool is_near(const Point3& from) const { return length_squared(center_ - from) < near_; }
  struct Seen {
    LinearDensity a, b;
    double density(const Vec2& at) const { return a.at(at.x) * b.at(at.y); }
  };
  /// How bright the middles of its sides are seen, about: by the distance to the power of -4, which
  /// is right for a surface parallel to it.
  Seen seen_from(const Point3& from) const {
    const Vec3 way = center_ - from;
    const double squared = length_squared(way);
    const auto along = [&](const Vec3& edge) {
      const double to_side = squared + length_squared(edge) / 4, shift = dot(way, edge);
      const double near = to_side - shift, far = to_side + shift;
      return LinearDensity(far * far, near * near);
    };
    return {along(a_), along(b_)};
  }
  void place(const Point3& point, SurfaceSample& sample) const {
    sample.point = point;
    sample.point_error = rounding_of(point, reach_);
    sample.normal = normal_;
  }

  Point3 corner_, center_;
  Vec3 a_, b_, normal_, share_a_, share_b_;
  double area_, reach_;
  double near_;  ///< the square of the distance of its middle up to which it is seen as near
};

/// Two triangles a face, counter-clockwise seen from outside.
void add_faces(const Bounds3& extent, TriangleSet& triangles) {
  const Vec3 size = extent.diagonal();
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    Vec3 across, u, v;
    across[axis] = size[axis];
    u[next] = size[next];
    v[last] = size[last];
    const auto add = [&](const Point3& p, const Vec3& s, const Vec3& t) {
      triangles.add({p, p + s, p + s + t});
      triangles.add({p, p + s + t, p + t});
    };
    add(extent.min + across, u, v);
    add(extent.min, v, u);
  }
}

/// The radius of what the sphere becomes; 0 where that is none.
double sphere_radius(const Affine& m, double radius) {
  Vec3 axes[3];
  for (size_t c = 0; c < 3; ++c) axes[c] = {m.m[0][c], m.m[1][c], m.m[2][c]};
  const double scale = length(axes[0]), tolerance = 1e-12 * scale * scale;
  for (int a = 0; a < 3; ++a) {
    if (std::abs(length_squared(axes[a]) - scale * scale) > tolerance) return 0;
    if (std::abs(dot(axes[a], axes[(a + 1) % 3])) > tolerance) return 0;
  }
  return scale * radius;
}

}  // namespace

std::unique_ptr<const SurfaceSampler> make_surface_sampler(const Shape& shape,
                                                           const Transform& world_from_object,
                                                           bool flip_normals) {
  const Affine& to_world = world_from_object.matrix();
  const auto turned = [&](const Vec3& normal) {
    const Vec3 n = normalize(static_cast<Vec3>(world_from_object.normal(to_normal(normal))));
    return flip_normals ? -n : n;
  };
  if (const auto* sphere = dynamic_cast<const Sphere*>(&shape)) {
    const double radius = sphere_radius(to_world, sphere->radius());
    if (radius == 0) {
      return make_ellipsoid_sampler(sphere->center(), sphere->radius(), world_from_object,
                                    flip_normals);
    }
    return std::make_unique<SphereSampler>(to_world(sphere->center()), radius, flip_normals);
  }
  if (const auto* disc = dynamic_cast<const Disc*>(&shape)) {
    const Vec3 a = disc->tangent(), b = cross(disc->normal(), a);
    return std::make_unique<DiscSampler>(
        to_world(disc->center()), to_world(a * disc->radius()), to_world(b * disc->radius()),
        disc->inner_radius() / disc->radius(), turned(disc->normal()));
  }
  if (const auto* rectangle = dynamic_cast<const Rectangle*>(&shape)) {
    return std::make_unique<RectangleSampler>(
        to_world(rectangle->corner()), to_world(rectangle->edge_u()), to_world(rectangle->edge_v()),
        turned(cross(rectangle->edge_u(), rectangle->edge_v())));
  }
  if (const auto* frustum = dynamic_cast<const Frustum*>(&shape))
    return make_frustum_sampler(frustum->parts(), world_from_object, flip_normals);
  if (const auto* torus = dynamic_cast<const Torus*>(&shape)) {
    return make_torus_sampler(torus->major_radius(), torus->minor_radius(), world_from_object,
                              flip_normals);
  }
  const auto triangles = std::make_shared<TriangleSet>();
  if (const auto* polygon = dynamic_cast<const ConvexPolygon*>(&shape)) {
    const auto points = polygon->points();
    for (size_t i = 2; i < points.size(); ++i)
      triangles->add({points[0], points[i - 1], points[i]});
  } else if (const auto* box = dynamic_cast<const Box*>(&shape)) {
    add_faces(box->bounds(), *triangles);
  }
  return make_triangle_sampler(triangles, world_from_object, flip_normals);
}

}  // namespace tessera
