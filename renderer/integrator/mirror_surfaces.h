#pragma once

#include <cstdint>
#include <span>
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
    Vec3 normal;                       ///< of the front; of a plane
    double facing = 1;                 ///< -1 where front and back change places; of a sphere
    std::span<const uint32_t> lights;  ///< that reach it, ascending
  };
  const Scene& scene() const { return scene_; }
  const MirrorPathFollower& alone() const { return alone_; }
  const Placed& placed(uint32_t instance) const { return placed_[instance]; }

 private:
  const Scene& scene_;
  const MirrorPathFollower& alone_;
  std::vector<std::vector<uint32_t>> lights_;  ///< by InstanceShading::light_set
  std::vector<Placed> placed_;                 ///< one an instance
};

}  // namespace tessera
