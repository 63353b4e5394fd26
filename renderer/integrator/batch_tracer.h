#pragma once

#include <cstddef>
#include <span>

#include "renderer/accel/ray_batch.h"
#include "renderer/integrator/integrator.h"

namespace tessera {

/// An integrator's radiance along camera rays, worked out of a batch of them at a time: what is
/// done to one ray is done to as many as a vector holds, by the arithmetic of a single ray line by
/// line, no product fused with a sum, so that the bits are the same. Immutable; thread-safe, each
/// thread with its state.
class BatchTracer {
 public:
  /// Rays at a time.
  static constexpr size_t kMost = RayBatch::kMost;

  virtual ~BatchTracer() = default;
  BatchTracer(const BatchTracer&) = delete;
  BatchTracer& operator=(const BatchTracer&) = delete;
  /// The radiance along each of 1 to kMost camera rays, which begin at the same t, into `found`;
  /// `keys` are those of the samples. Another number of any is refused by a check, as are a first
  /// and a last ray whose t_min differ.
  void radiances(std::span<const Ray> rays, std::span<const SampleKey> keys, std::span<Color> found,
                 TraceState& state) const;
  /// The same of a pinhole's rays through raster points.
  void radiances(const Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
                 std::span<const SampleKey> keys, std::span<Color> found, TraceState& state) const;

 protected:
  BatchTracer() = default;

 private:
  virtual void follow(std::span<const Ray> rays, std::span<const SampleKey> keys,
                      std::span<Color> found, TraceState& state) const = 0;
  virtual void follow(const Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
                      std::span<const SampleKey> keys, std::span<Color> found,
                      TraceState& state) const = 0;
};

}  // namespace tessera
