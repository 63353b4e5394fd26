#pragma once

#include <cstdint>
#include <vector>

#include "renderer/integrator/whitted_batches.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// What batches from mirror to mirror know of a scene, worked out once. Immutable; `scene` and
/// `alone` must outlive it.
class WhittedSurfaces {
 public:
  WhittedSurfaces(const Scene& scene, const SegmentTracer& alone);

  /// How the surface at a hit of an instance is worked out.
  enum class Form : uint8_t { plane, sphere, other };
  struct Placed {
    Form form = Form::other;
    Vec3 normal;             ///< of the front; of a plane
    double facing = 1;       ///< -1 where front and back change places; of a sphere
    uint32_t light_set = 0;  ///< InstanceShading::light_set
  };
  const Scene& scene() const { return scene_; }
  const SegmentTracer& alone() const { return alone_; }
  const Placed& placed(uint32_t instance) const { return placed_[instance]; }
  /// Whether shadow rays are faster together.
  bool batches_shadows() const { return batches_shadows_; }
  /// Of the scene and all lights that reach instances of the set.
  const Color& ambient(uint32_t light_set) const { return ambients_[light_set]; }

 private:
  const Scene& scene_;
  const SegmentTracer& alone_;
  bool batches_shadows_;
  std::vector<Color> ambients_;  ///< by InstanceShading::light_set
  std::vector<Placed> placed_;   ///< one an instance
};

}  // namespace tessera
