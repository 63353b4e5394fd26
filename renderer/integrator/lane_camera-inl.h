// Compiled once for each instruction set: rays of a pinhole, a lane each.
#if defined(TESSERA_LANE_CAMERA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANE_CAMERA_INL_H
#undef TESSERA_LANE_CAMERA_INL_H
#else
#define TESSERA_LANE_CAMERA_INL_H
#endif

#include <hwy/highway.h>

#include <span>

#include "renderer/accel/ray_batch.h"
#include "renderer/camera/camera.h"
#include "renderer/integrator/lane_batch-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/sampler/sampler.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

#include "renderer/camera/pinhole-inl.h"

static_assert(sizeof(Sampler::RasterSample) == 3 * sizeof(double));

/// Camera::ray() through each, at most RayBatch::kMost.
HWY_INLINE void set_rays(const Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
                         RayBatch& batch) {
  batch.begin(camera.near_distance, camera.far_distance);
  batch.count = rasters.size();
  const Lanes3 eye = broadcast(camera.eye);
  const LaneIndices last = hn::Set(kIndexTag, static_cast<int64_t>(rasters.size() - 1));
  for (size_t i = 0; i < rasters.size(); i += kLanes) {
    const LaneIndices number = hn::Min(hn::Iota(kIndexTag, static_cast<int64_t>(i)), last);
    const LaneIndices at = hn::ShiftLeft<1>(number) + number;
    const Lanes x = gather(&rasters[0].point.x, at), y = gather(&rasters[0].point.y, at);
    store(pinhole_direction(camera, x, y), i, batch.direction);
    store(eye, i, batch.origin);
  }
}
/// Of rays that begin at the same t.
HWY_INLINE void set_rays(std::span<const Ray> rays, RayBatch& batch) {
  batch.begin(rays[0].t_min);
  batch.count = rays.size();
  for (size_t i = 0; i < rays.size(); ++i) {
    batch.t_max[i] = rays[i].t_max;
    for (int axis = 0; axis < 3; ++axis) {
      batch.origin[axis][i] = rays[i].origin[axis];
      batch.direction[axis][i] = rays[i].direction[axis];
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
