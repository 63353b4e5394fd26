#include "renderer/integrator/batch_tracer.h"

#include <fmt/format.h>

#include "base/error.h"

namespace tessera {

namespace {

void check_sizes(size_t rays, size_t keys, size_t found) {
  TESSERA_CHECK(rays >= 1 && rays <= BatchTracer::kMost && keys == rays && found == rays,
                fmt::format("{} rays, {} keys, {} found", rays, keys, found));
}

}  // namespace

void BatchTracer::radiances(std::span<const Ray> rays, std::span<const SampleKey> keys,
                            std::span<Color> found, TraceState& state) const {
  check_sizes(rays.size(), keys.size(), found.size());
  // Of all rays it would take a part in three hundred of the instructions of a lens.
  const Ray &first = rays.front(), &last = rays.back();
  TESSERA_CHECK(first.t_min == last.t_min,
                fmt::format("t_min {} and {}; expected the same", first.t_min, last.t_min));
  follow(rays, keys, found, state);
}

void BatchTracer::radiances(const Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
                            std::span<const SampleKey> keys, std::span<Color> found,
                            TraceState& state) const {
  check_sizes(rasters.size(), keys.size(), found.size());
  follow(camera, rasters, keys, found, state);
}

}  // namespace tessera
