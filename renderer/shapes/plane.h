#pragma once

#include "renderer/shapes/shape.h"

namespace tessera {

/// The endless plane normal . p = offset. Its bounds are endless on every axis. No texture
/// coordinates of its own: uv are metres along two unit tangents from the foot of the origin.
class Plane final : public Shape {
 public:
  /// `normal` of any length but 0; `offset` is along the unit normal.
  Plane(const Vec3& normal, double offset);
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;

 private:
  Vec3 normal_;
  double offset_;
};

}  // namespace tessera
