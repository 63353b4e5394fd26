#pragma once

#include <cstdint>
#include <memory>

#include "renderer/integrator/direct_background.h"
#include "renderer/integrator/integrator.h"
#include "renderer/render/sample_sum.h"
#include "renderer/render/tile_renderer.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// What a pixel holds beside light. Surfaces are looked for along the very camera rays that light
/// came by, once more and by themselves: who asks for nothing has nothing done, and light keeps its
/// bits. Immutable; any thread.
class AovTracer {
 public:
  explicit AovTracer(std::shared_ptr<const Scene> scene);

  AovSet aovs() const { return aovs_; }
  /// Means over so many samples of the pixel at x, y from `first_sample` on. For scenes with alpha.
  DirectBackground background_of(int x, int y, uint32_t first_sample, uint32_t count,
                                 TraceState& state, TileProgress& progress) const;
  /// To `out`, the channels behind light of the pixel at x, y, whose light is the mean of samples
  /// from `first_sample` on. `seen`: its rays may meet something. What no float holds becomes 0,
  /// and what comes where it is cancelled is of no use.
  void write(int x, int y, uint32_t first_sample, bool seen, const SampleSum& light, double alpha,
             TraceState& state, TileProgress& progress, float* out) const;

 private:
  struct Surfaces;
  Surfaces surfaces_of(int x, int y, uint32_t first_sample, uint32_t count, TraceState& state,
                       TileProgress& progress) const;

  std::shared_ptr<const Scene> scene_;
  AovSet aovs_;
  Media at_camera_;  ///< what the camera is inside of; with alpha
};

}  // namespace tessera
