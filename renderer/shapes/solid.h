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
  /// False for a shape with an inside of which parts are left out: CSG refuses it.
  virtual bool closed() const { return true; }
  /// Appends all crossings of the whole line origin + t direction, t_min and t_max notwithstanding,
  /// by ascending t. The line starts outside: where it runs inside from the start or to the end,
  /// t is -infinity or +infinity. Entering and leaving balance; crossings whose errors overlap may
  /// come in either order. `error` widens the errors reported, and changes no t.
  virtual void crossings(const Ray& ray, const RayError& error,
                         std::vector<SolidEvent>& events) const = 0;
};

/// How far the line may be from where it seems to be at t, along a normal n (any length) and in
/// units of n's length, where it crosses a surface whose own distance is known to within
/// `distance`. Over |n . direction| this is the error of t.
inline double crossing_depth(const Vec3& n, double t, const RayError& error, double distance) {
  const Vec3 size = abs(n);
  return distance + dot(size, error.origin) + std::abs(t) * dot(size, error.direction);
}

}  // namespace tessera
