#pragma once

#include <cstdint>
#include <vector>

#include "renderer/integrator/mirror_rows.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// What rows from mirror to mirror know of a scene, worked out once. Immutable; `scene` and `alone`
/// must outlive it.
class MirrorSurfaces {
 public:
  MirrorSurfaces(const Scene& scene, const MirrorPathFollower& alone);

  /// How the surface at a hit of an instance is worked out.
  enum class Form : uint8_t { plane, sphere, other };
  struct Placed {
    Form form = Form::other;
    Vec3 normal;             ///< of the front; of a plane
    double facing = 1;       ///< -1 where front and back change places; of a sphere
    uint32_t light_set = 0;  ///< InstanceShading::light_set
  };
  const Scene& scene() const { return scene_; }
  const MirrorPathFollower& alone() const { return alone_; }
  const Placed& placed(uint32_t instance) const { return placed_[instance]; }
  /// Of the scene and all lights that reach instances of the set.
  const Color& ambient(uint32_t light_set) const { return ambients_[light_set]; }

 private:
  const Scene& scene_;
  const MirrorPathFollower& alone_;
  std::vector<Color> ambients_;  ///< by InstanceShading::light_set
  std::vector<Placed> placed_;   ///< one an instance
};

}  // namespace tessera
