#pragma once

#include "renderer/shapes/shape.h"

namespace tessera {

/// The part of a plane with edge_normal . (p - point) >= 0; its front is where the normal points.
/// uv are metres from `point`, u into the half-plane and v along its edge.
class HalfPlane final : public Shape {
 public:
  /// Normals of any length but 0, not parallel. Throws Error otherwise.
  HalfPlane(const Point3& point, const Vec3& normal, const Vec3& edge_normal);
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;

 private:
  Point3 point_;
  Vec3 normal_;
  Vec3 edge_;  ///< along the edge, the half-plane on its left seen from the front
};

}  // namespace tessera
