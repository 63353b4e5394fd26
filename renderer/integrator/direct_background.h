#pragma once

#include "renderer/integrator/integrator.h"

namespace tessera {

/// What a camera ray brings of the background that it sees directly: past everything, or through
/// surfaces that are only in part there (alpha, unbent transparency). What is refracted or mirrored
/// is of a surface.
struct DirectBackground {
  Color share;  ///< of the background, in [0, 1]
  Color light;  ///< that share of its radiance: as much as is in what the scene's integrator finds
  DirectBackground& operator+=(const DirectBackground& o) {
    share += o.share;
    light += o.light;
    return *this;
  }
  DirectBackground operator*(double s) const { return {share * s, light * s}; }
};

/// Of the camera ray that the integrator follows with that key; `at_camera` is what the camera is
/// inside of (media_at_camera()).
DirectBackground direct_background(const Scene& scene, const Media& at_camera, Ray ray,
                                   const SampleKey& key, TraceState& state);

}  // namespace tessera
