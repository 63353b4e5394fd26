#pragma once

#include "renderer/shapes/shape.h"

namespace tessera {

/// The part of a plane between two circles; its front is where the normal points. Texture
/// coordinates span the square around it, upright seen from the front.
class Disc final : public Shape {
 public:
  /// `normal` of any length but 0; 0 <= inner_radius < radius. Throws Error otherwise.
  Disc(const Point3& center, const Vec3& normal, double radius, double inner_radius = 0);
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;

 private:
  Point3 center_;
  Vec3 normal_;
  Vec3 tangent_;
  double radius_, inner_radius_;
};

}  // namespace tessera
