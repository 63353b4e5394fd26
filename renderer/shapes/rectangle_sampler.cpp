// How points of a Rectangle are chosen.
#include <algorithm>
#include <cmath>

#include "renderer/math/transform.h"
#include "renderer/shapes/area_density.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/spherical_rectangle.h"
#include "renderer/shapes/surface_sampler.h"

namespace tessera {
namespace {

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

}  // namespace

std::unique_ptr<const SurfaceSampler> Rectangle::make_sampler(const Transform& world_from_object,
                                                              bool flip_normals) const {
  const Affine& to_world = world_from_object.matrix();
  return std::make_unique<RectangleSampler>(
      to_world(corner_), to_world(edge_u_), to_world(edge_v_),
      unit_normal(world_from_object, cross(edge_u_, edge_v_), flip_normals));
}

}  // namespace tessera
