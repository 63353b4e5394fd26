#pragma once

#include "renderer/shapes/solid.h"

namespace tessera {

/// The solid box between two corners. Primitives are its faces: 0 to 5 for -x +x -y +y -z +z. Each
/// face carries uv in [0, 1], upright seen from outside as X3D maps a box.
class Box final : public ConvexSolid {
 public:
  explicit Box(const Bounds3& extent) : extent_(extent) {}
  Bounds3 bounds() const override { return extent_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  bool span(const Ray& ray, const RayError& error, SolidSpan& span) const override;
  size_t primitive_count() const override { return 6; }
  /// By area.
  std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                     bool flip_normals) const override;

 private:
  Bounds3 extent_;
};

}  // namespace tessera
