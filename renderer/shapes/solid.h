#pragma once

#include <vector>

#include "renderer/shapes/shape.h"

namespace tessera {

/// Bounds, on each axis, on how far a ray's origin and direction may be from what they stand for.
struct RayError {
  Vec3 origin, direction;
};

/// Where a line enters or leaves a solid.
struct SolidEvent {
  double t = 0;
  double error = 0;  ///< bound on |t - the true t|; 0 at an endless end
  bool entering = false;
  uint32_t primitive = 0;  ///< as in Hit
  double u = 0, v = 0;     ///< as in Hit
};

/// A shape with an inside, so that CSG can combine it. A Shape that is no Solid is open.
class Solid : public Shape {
 public:
  using Shape::Shape;
  /// False for a shape with an inside and parts left out: CSG refuses it.
  virtual bool closed() const { return true; }
  /// Appends all crossings of the whole line origin + t direction, t_min and t_max notwithstanding,
  /// by ascending t. The line starts outside: where it runs inside from the start or to the end,
  /// t is -infinity or +infinity. Entering and leaving balance; crossings whose errors overlap may
  /// come in either order. `error` widens the errors reported, and changes no t.
  virtual void crossings(const Ray& ray, const RayError& error,
                         std::vector<SolidEvent>& events) const = 0;
  /// By crossings(), which balance: a line that touches the surface counts as often in as out.
  int crossing_number(const Ray& ray, std::span<const Hit> hits) const override;
  /// Whether the ray starts inside; any direction that is not zero serves.
  bool holds_start(const Ray& ray) const;
};

/// The stretch of a line that is inside a convex solid; t is infinite where it has no end.
struct SolidSpan {
  SolidEvent enter{.t = -Bounds3::kInfinity, .entering = true};
  SolidEvent leave{.t = Bounds3::kInfinity};
};

/// Where a point is with regard to a solid.
enum class Side : uint8_t { inside, outside, in_doubt };

/// A solid that a line enters at most once, and whose hits have no u and v.
class ConvexSolid : public Solid {
 public:
  using Solid::Solid;
  /// As crossings(): false where the line misses.
  virtual bool span(const Ray& ray, const RayError& error, SolidSpan& span) const = 0;
  /// Where `p` is, if it is farther than `margin` from the surface and that is cheap to tell.
  virtual Side side_of(const Point3&, double /*margin*/) const { return Side::in_doubt; }
  void crossings(const Ray& ray, const RayError& error,
                 std::vector<SolidEvent>& events) const final {
    SolidSpan inside;
    if (!span(ray, error, inside)) return;
    events.push_back(inside.enter);
    events.push_back(inside.leave);
  }
};

/// How far the line may be from where it seems to be at t, along a normal n (any length) and in
/// units of n's length, where it crosses a surface whose own distance is known to within
/// `distance`. Over |n . direction| this is the error of t.
inline double crossing_depth(const Vec3& n, double t, const RayError& error, double distance) {
  const Vec3 size = abs(n);
  return distance + dot(size, error.origin) + std::abs(t) * dot(size, error.direction);
}

}  // namespace tessera
