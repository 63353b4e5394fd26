#include "renderer/integrator/mirror_rows.h"

#include <algorithm>

#include "renderer/accel/mesh_shape.h"
#include "renderer/integrator/mirror_surfaces.h"
#include "renderer/math/targets.h"

// This file is compiled once for each instruction set, as bvh_kernels.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/integrator/mirror_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/integrator/mirror_row_follower-inl.h"
#include "renderer/integrator/row_follower-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

std::unique_ptr<const RowTracer> mirror_rows(const Scene& scene, const MirrorPathFollower& alone) {
  return std::make_unique<RowTracerOf<MirrorRowFollower>>(scene, alone);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

bool can_follow_mirrors(const Scene& scene) {
  const auto is_even = [](const Light& light) {
    return light.kind == LightKind::point || light.kind == LightKind::directional;
  };
  return scene.features.simple && scene.surfaces && std::ranges::all_of(scene.lights, is_even) &&
         std::ranges::none_of(scene.instances, [](const Instance& instance) {
           return dynamic_cast<const MeshShape*>(instance.shape.get());
         });
}

std::unique_ptr<const RowTracer> make_mirror_rows(const Scene& scene,
                                                  const MirrorPathFollower& alone,
                                                  std::string_view instructions) {
  return code_of_target(TESSERA_EACH_TARGET(mirror_rows), instructions)(scene, alone);
}

}  // namespace tessera
#endif  // HWY_ONCE
