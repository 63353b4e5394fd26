#pragma once

#include <cstdint>
#include <vector>

#include "renderer/math/color.h"
#include "renderer/scene/scene.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// What batches of paths know of a scene's surfaces, worked out once. Immutable; `scene` must
/// outlive it.
class PathSurfaces {
 public:
  explicit PathSurfaces(const Scene& scene);
  PathSurfaces(const PathSurfaces&) = delete;
  PathSurfaces& operator=(const PathSurfaces&) = delete;

  /// How the surface at a hit of an instance is worked out.
  enum class Form : uint8_t { rectangle, mesh, other };
  /// What is seen of a material without textures and vertex colours.
  struct Side {
    Color diffuse;
    bool emits = false;
  };
  struct Placed {
    Form form = Form::other;
    const Instance* instance = nullptr;
    const Rectangle* rectangle = nullptr;  ///< as it stands in the world
    Vec3 normal;                           ///< of the rectangle's front
    const TriangleMesh* mesh = nullptr;
    bool is_even = false;                          ///< all its materials only scatter evenly
    bool has_inputs = false;                       ///< some material is to be looked up
    bool is_uniform = false;                       ///< neither colours nor materials differ on it
    const Side *front = nullptr, *back = nullptr;  ///< null: hits are to be asked one by one
  };
  const Scene& scene() const { return scene_; }
  const Placed& placed(uint32_t instance) const { return placed_[instance]; }
  /// Whether something may be passed straight, or absorbs.
  bool passes() const { return passes_; }
  /// What the camera is inside of.
  const Media& at_camera() const { return at_camera_; }

 private:
  Placed place(uint32_t number) const;
  void find_sides(uint32_t number, Placed& placed) const;

  const Scene& scene_;
  bool passes_;
  Media at_camera_;
  std::vector<Side> sides_;     ///< one a material
  std::vector<Placed> placed_;  ///< one an instance
};

}  // namespace tessera
