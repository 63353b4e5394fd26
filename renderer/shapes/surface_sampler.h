#pragma once

#include <cstdint>

#include "renderer/math/bounds.h"
#include "renderer/math/vec.h"

namespace tessera {

/// A point of a surface in world space.
struct SurfaceSample {
  Point3 point;
  Vec3 point_error;  ///< bound on each axis
  Vec3 normal;       ///< unit; where the shape's front is
};

/// A point of a surface to which light comes. Both must outlive it.
struct LitPoint {
  const Point3& at;
  const Vec3& normal;  ///< unit, geometric, on the side that counts
};

/// Chooses points of a surface as they are seen from elsewhere, for light that comes from it.
/// Immutable after construction; thread-safe; does not allocate.
class SurfaceSampler {
 public:
  virtual ~SurfaceSampler() = default;
  /// The point that `u`, uniform in [0, 1)^2, chooses, and the density of its direction per
  /// steradian seen from `from`; 0 where there is none to choose.
  virtual double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const = 0;
  /// The density with which sample() chooses `there`, a point of the surface with its normal;
  /// `primitive` is that of a hit there (Hit::primitive), which meshes ask for.
  virtual double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                         uint32_t primitive) const = 0;
  virtual double area() const = 0;     ///< square metres, > 0
  virtual Bounds3 bounds() const = 0;  ///< about, rounding apart
  /// Whether all of it lies in one plane, through `at` across `normal`, which shows the front.
  virtual bool is_flat(Point3& /*at*/, Vec3& /*normal*/) const { return false; }
};

}  // namespace tessera
