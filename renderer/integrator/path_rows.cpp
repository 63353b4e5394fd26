#include "renderer/integrator/path_rows.h"

#include <cmath>

#include "renderer/integrator/path_surfaces.h"
#include "renderer/math/targets.h"

// This file is compiled once for each instruction set, as bvh_kernels.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/integrator/path_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/integrator/path_row_follower-inl.h"
#include "renderer/integrator/row_follower-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

std::unique_ptr<const RowTracer> path_rows(const Scene& scene) {
  return std::make_unique<RowTracerOf<PathRowFollower>>(scene);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

bool can_follow_paths(const Scene& scene) {
  const bool skips_textures = !scene.features.rich || scene.skips.texture_points;
  // Rays of a row end at the same distance, but those that have passed a veil would have less left.
  const bool is_endless = std::isinf(scene.camera->far_distance());
  return scene.surfaces && (is_endless || !scene.features.veils) &&
         scene.fog.kind == FogKind::none && scene.skips.absent_features && skips_textures;
}

std::unique_ptr<const RowTracer> make_path_rows(const Scene& scene, std::string_view instructions) {
  return code_of_target(TESSERA_EACH_TARGET(path_rows), instructions)(scene);
}

}  // namespace tessera
#endif  // HWY_ONCE
