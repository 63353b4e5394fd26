#pragma once

#include <cstdint>
#include <vector>

#include "renderer/integrator/whitted_hit.h"
#include "renderer/scene/scene.h"
#include "renderer/shading/media.h"

namespace tessera {

/// What Whitted's batches know of a scene, worked out once. Immutable; `scene` must outlive it.
class WhittedSurfaces {
 public:
  explicit WhittedSurfaces(const Scene& scene);

  /// How the surface at a hit of an instance is worked out.
  enum class Form : uint8_t { plane, sphere, other };
  struct Placed {
    Form form = Form::other;
    Vec3 normal;             ///< of the front; of a plane
    double facing = 1;       ///< -1 where front and back change places; of a sphere
    uint32_t light_set = 0;  ///< InstanceShading::light_set
    bool is_simple = false;  ///< its hits are looked at in vectors, else one by one
  };
  const Scene& scene() const { return scene_; }
  const Placed& placed(uint32_t instance) const { return placed_[instance]; }
  /// Whether all surfaces are simple and seen from both sides, so that no hit is looked at by
  /// itself: by the last digit, rays hit culled backs.
  bool are_simple() const { return are_simple_; }
  /// What the camera is inside of.
  const Media& at_camera() const { return at_camera_; }
  /// Of a hit that is looked at by itself.
  Color look(const PathSegment& segment, const Hit& hit, const SampleKey& key, Branches& branches,
             TraceState& state) const {
    return (scene_.features.rich ? whitted_hit<true> : whitted_hit<false>)(scene_, segment, hit,
                                                                           key, branches, state);
  }
  /// Whether shadow rays are faster together.
  bool batches_shadows() const { return batches_shadows_; }
  /// Of the scene and all lights that reach instances of the set.
  const Color& ambient(uint32_t light_set) const { return ambients_[light_set]; }

 private:
  const Scene& scene_;
  bool batches_shadows_;
  bool are_simple_ = true;
  Media at_camera_;
  std::vector<Color> ambients_;  ///< by InstanceShading::light_set
  std::vector<Placed> placed_;   ///< one an instance
};

}  // namespace tessera
