#pragma once

#include <optional>

#include "renderer/integrator/integrator.h"
#include "renderer/render/aov_tracer.h"
#include "renderer/render/sample_sum.h"
#include "renderer/render/tile_renderer.h"

namespace tessera {

/// Where the pixels of a tile go, and what is told of how far it is. Of one thread. All that it is
/// made of must outlive it.
class TileWriter {
 public:
  TileWriter(const Scene& scene, const AovTracer& aovs, uint32_t first_sample, TilePixels& tile,
             TileProgress& progress)
      : scene_(scene), aovs_(aovs), first_sample_(first_sample), tile_(tile), progress_(progress) {}

  /// A pixel of such samples, and what is beside its light. `seen`: its rays may meet something.
  /// The standard error where it is known better than by the spread of the pixel's own samples.
  void put(const SampleSum& sum, int x, int y, bool seen,
           std::optional<double> error = std::nullopt);
  /// A pixel that is nothing but what its only sample finds.
  void put_lone(const Sample& sample, int x, int y) {
    put_color(kBlack + sample.color, value_at(x, y));  // no -0
  }

  CounterMap& counters() { return tile_.counters; }
  TileProgress& progress() { return progress_; }
  uint64_t rays_beside_light() const { return beside_light_.counters.rays_primary; }

 private:
  Color shown(const SampleSum& sum, std::optional<double> error) const;
  float* value_at(int x, int y) {
    const PixelRect& rect = tile_.rect;
    const size_t at = static_cast<size_t>(int64_t{y - rect.y0} * rect.width() + (x - rect.x0));
    return &tile_.values[at * static_cast<size_t>(tile_.channels)];
  }
  /// Where what is beside light goes.
  static float* put_color(const Color& color, float* value) {
    for (const double channel : {color.r, color.g, color.b}) *value++ = static_cast<float>(channel);
    return value;
  }

  const Scene& scene_;
  const AovTracer& aovs_;
  uint32_t first_sample_;
  TraceState beside_light_;  ///< what AOVs cost
  TilePixels& tile_;
  TileProgress& progress_;
};

}  // namespace tessera
