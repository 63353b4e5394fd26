#pragma once

#include "renderer/math/transform.h"
#include "renderer/shapes/surface_sampler.h"

namespace tessera {

/// In the shape's frame.
struct CurvedPoint {
  Point3 point;
  Vec3 normal;  ///< unit; out
};

/// Spreads points evenly over a curved surface in its own frame: each shape gives its points. A
/// transform that is no similarity spreads them unevenly.
class CurvedSampler : public SurfaceSampler {
 public:
  /// `area` and `box` in the shape's frame.
  CurvedSampler(double area, const Bounds3& box, const Transform& to_world, bool flip)
      : own_area_(area),
        to_world_(to_world),
        flip_(flip),
        bounds_(to_world.bounds(box)),
        reach_(length(bounds_.diagonal())) {}
  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override;
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t) const override;
  /// About, where the transform is no similarity.
  double area() const override;
  Bounds3 bounds() const override { return bounds_; }

 private:
  virtual CurvedPoint choose(const Vec2& u) const = 0;

  double own_area_;
  Transform to_world_;
  bool flip_;
  Bounds3 bounds_;
  double reach_;
};

}  // namespace tessera
