#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "renderer/math/color.h"
#include "renderer/scene/light_tree.h"
#include "renderer/shapes/surface_sampler.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// An emissive surface as a light: one material of one instance.
struct AreaLight {
  std::shared_ptr<const SurfaceSampler> sampler;
  uint32_t instance = 0;
  uint32_t material = 0;                ///< LocalSurface::material of its points
  Color front = kBlack, back = kBlack;  ///< radiance towards either side, textures apart
  bool has_texture = false;             ///< what multiplies the radiance is to be looked up
  Point3 at;                            ///< of the plane of a flat one
  Vec3 dark_normal;  ///< of the side of the plane where it is black; zero: there is none such

  /// Whether it is flat and `from` lies, clearly, where it emits nothing.
  bool is_dark_from(const Point3& from) const {
    constexpr double kClearly = 1e-9;  // far above the rounding of any point of the plane
    const Vec3 way = from - at;
    return dot(way, dark_normal) >
           kClearly * (dot(abs(way), abs(dark_normal)) + dot(abs(at - Point3{}), abs(dark_normal)));
  }
};

/// The lights that have an extent. Surfaces that cannot be chosen from (endless, of a shape without
/// a sampler, alpha) are not among them: paths find them by themselves. Immutable once built;
/// thread-safe.
class AreaLights {
 public:
  AreaLights() = default;
  /// `lights` in ascending order of instance and material.
  explicit AreaLights(std::vector<AreaLight> lights);
  bool empty() const { return lights_.empty(); }
  size_t size() const { return lights_.size(); }
  const AreaLight& operator[](uint32_t index) const { return lights_[index]; }
  /// How one is picked.
  const LightTree& tree() const { return tree_; }
  /// The light that a surface is.
  std::optional<uint32_t> find(uint32_t instance, uint32_t material) const;

 private:
  std::vector<AreaLight> lights_;
  LightTree tree_;
};

struct Scene;

/// The surfaces of the scene's instances that emit. `meshes` is one an instance: what its shape is
/// made of, null where that is no mesh.
AreaLights find_area_lights(const Scene& scene, std::span<const TriangleMesh* const> meshes);

}  // namespace tessera
