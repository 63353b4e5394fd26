#include "renderer/sampler/draw_rasters.h"

#include <algorithm>

#include "base/targets.h"

// This file is compiled once for each instruction set, as bvh_kernels.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/sampler/draw_rasters.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/math/lanes-inl.h"
#include "renderer/sampler/lane_sampler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

void draw_points(const Sampler& sampler, std::span<const SampleKey> keys,
                 std::span<Sampler::RasterSample> samples) {
  for (size_t begin = 0; begin < keys.size(); begin += kLanes) {
    const size_t count = std::min(kLanes, keys.size() - begin);
    SampleStream streams[kLanes];
    const SampleStream* each[kLanes];
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const SampleKey& key = keys[begin + std::min(lane, count - 1)];
      streams[lane] = sampler.stream(key.x, key.y, key.sample);
      each[lane] = &streams[lane];
    }
    const Lanes2 pair = LaneStream(each).pair(SampleUse::pixel);
    alignas(64) double u[kLanes], v[kLanes];
    hn::Store(pair.x, kLaneTag, u);
    hn::Store(pair.y, kLaneTag, v);
    for (size_t lane = 0; lane < count; ++lane) {
      const SampleKey& key = keys[begin + lane];
      samples[begin + lane] = sampler.filtered(key.x, key.y, {u[lane], v[lane]});
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

namespace {

void draw_one_by_one(const Sampler& sampler, std::span<const SampleKey> keys,
                     std::span<Sampler::RasterSample> samples) {
  std::ranges::transform(keys, samples.begin(), [&](const SampleKey& key) {
    return sampler.raster_sample(key.x, key.y, key.sample);
  });
}

}  // namespace

DrawRasters raster_drawer(const Sampler& sampler, std::string_view instructions) {
  if (!sampler.draws_points()) return draw_one_by_one;
  return code_of_target(TESSERA_EACH_TARGET(draw_points), instructions);
}

}  // namespace tessera
#endif  // HWY_ONCE
