#pragma once

#include "renderer/shapes/solid.h"

namespace tessera {

/// The endless plane normal . p = offset; as a solid, the half-space below it. Its bounds are
/// endless on every axis. No texture coordinates of its own: uv are metres along two unit tangents
/// from the foot of the origin.
class Plane final : public Solid {
 public:
  /// `normal` of any length but 0; `offset` is along the unit normal.
  Plane(const Vec3& normal, double offset);
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  void crossings(const Ray& ray, const RayError& error,
                 std::vector<SolidEvent>& events) const override;

 private:
  Vec3 normal_;
  double offset_;
};

}  // namespace tessera
