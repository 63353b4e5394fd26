#pragma once

#include "renderer/shapes/shape.h"

namespace tessera {

/// The part of a plane between two circles; its front is where the normal points. Texture
/// coordinates span the square around it, upright seen from the front.
class Disc final : public Shape {
 public:
  /// `normal` of any length but 0; 0 <= inner_radius < radius. Throws Error otherwise.
  Disc(const Point3& center, const Vec3& normal, double radius, double inner_radius = 0);
  const Point3& center() const { return center_; }
  const Vec3& normal() const { return normal_; }    ///< unit
  const Vec3& tangent() const { return tangent_; }  ///< unit, across the normal
  double radius() const { return radius_; }
  double inner_radius() const { return inner_radius_; }
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  /// By area.
  std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                     bool flip_normals) const override;
  std::vector<Point3> outline() const override;

 private:
  Point3 center_;
  Vec3 normal_;
  Vec3 tangent_;
  double radius_, inner_radius_;
};

}  // namespace tessera
