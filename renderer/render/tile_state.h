#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/render/sample_sum.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// A pixel past everything where all of them are alike (is_uniform_beyond()).
struct PixelBeyond {
  SampleSum sum;
  TraceCounters counters;
};

/// What one thread needs for a tile.
struct TileState : TraceState {
  PixelBeyond beyond;  ///< set where the tile may have some

  /// Its samples, counted as if they had been worked out anew.
  const SampleSum& sum_beyond() {
    counters.samples += beyond.counters.samples;
    counters.samples_skipped += beyond.counters.samples_skipped;
    counters.nan_samples += beyond.counters.nan_samples;
    return beyond.sum;
  }
};

/// Whether all pixels past everything are alike: before a background of one colour, or one that is
/// left out.
inline bool is_uniform_beyond(const Scene& scene) {
  return scene.background.is_constant() || scene.settings.aovs.has(Aov::alpha);
}
/// Whether a sample of the pixel can hit anything.
inline bool is_seen(const Scene& scene, int x, int y) {
  return scene.seen.contains({x, y, x + 1, y + 1});
}

}  // namespace tessera
