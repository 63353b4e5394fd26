#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/surface_point.h"

namespace tessera {

/// Emission, ambient light and the light of every light of the point's set, towards `wo`.
/// `path_length` is that from the camera to the point.
template <bool kShadows>
Color local_radiance(const Scene& scene, const SurfacePoint& point, const Vec3& wo,
                     double path_length, TraceCounters& counters);

}  // namespace tessera
