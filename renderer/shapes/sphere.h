#pragma once

#include "renderer/shapes/solid.h"

namespace tessera {

/// The sphere about `center`; `radius` > 0. Texture coordinates as X3D maps a sphere: u runs
/// counter-clockwise seen from +y from the seam at -z, v from 0 at -y to 1 at +y.
class Sphere final : public Solid {
 public:
  Sphere(const Point3& center, double radius) : center_(center), radius_(radius) {}
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  void crossings(const Ray& ray, const RayError& error,
                 std::vector<SolidEvent>& events) const override;

 private:
  /// Roots in ascending order; false where the ray misses.
  bool roots(const Ray& ray, double& t0, double& t1) const;

  Point3 center_;
  double radius_;
};

}  // namespace tessera
