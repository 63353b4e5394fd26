#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/render/sample_sum.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// A pixel past everything before a background of one colour: all of them are alike.
struct PixelBeyond {
  SampleSum sum;
  TraceCounters counters;
};

/// What one thread needs for a tile.
struct TileState : TraceState {
  PixelBeyond beyond;  ///< set where the tile may have some and the background has one colour

  /// Its samples, counted as if they had been worked out anew.
  const SampleSum& sum_beyond() {
    counters.samples += beyond.counters.samples;
    counters.samples_skipped += beyond.counters.samples_skipped;
    counters.nan_samples += beyond.counters.nan_samples;
    return beyond.sum;
  }
};

/// Whether a sample of the pixel can hit anything.
inline bool is_seen(const Scene& scene, int x, int y) {
  return scene.seen.contains({x, y, x + 1, y + 1});
}

}  // namespace tessera
