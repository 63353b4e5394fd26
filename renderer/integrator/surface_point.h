#pragma once

#include <optional>

#include "renderer/scene/scene.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {

/// A hit, seen from where the ray came: its material for the side that is seen and normals turned
/// towards the viewer.
struct SurfacePoint {
  SurfacePoint() = default;
  SurfacePoint(const SurfacePoint&) = delete;
  SurfacePoint& operator=(const SurfacePoint&) = delete;

  SurfaceInteraction surface;
  const Material* material = nullptr;  ///< the scene's, or `resolved`
  Vec3 geometric_normal;               ///< unit, towards the viewer
  Vec3 normal;                         ///< unit, for shading
  bool is_back = false;                ///< the ray met the back of the surface: it was inside
  bool is_hidden = false;              ///< a back face that is not there
  std::optional<Material> resolved;    ///< the material with its textures looked up
};

/// Finds what lies at the hit. Without kRich the scene must have no rich materials. `width`, in
/// metres, is that of the patch across the ray that the point stands for in textures.
template <bool kRich>
void find_surface_point(const Scene& scene, uint32_t instance_index, const Ray& ray, const Hit& hit,
                        double width, SurfacePoint& point);

/// How much of what is behind the surface comes straight through, and the rest. For a refracting
/// material 0 and 1: what it lets through is bent.
struct Coverage {
  double through = 0, covered = 1;
};
Coverage straight_coverage(const SurfacePoint& point);

}  // namespace tessera
