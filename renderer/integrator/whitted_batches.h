#pragma once

#include <memory>
#include <string_view>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/integrator/batch_tracer.h"

namespace tessera {

/// Whitted's rays through a scene in batches, from mirror to mirror, by the instructions of the set
/// that BvhKernels of that name are of. Hits of simple materials (WhittedSurfaces) are looked at
/// in vectors, others by whitted_hit(). `scene` must outlive it. The keys tell the rays' cones too.
std::unique_ptr<const BatchTracer> make_whitted_batches(
    const Scene& scene, std::string_view instructions = kernels().name);

}  // namespace tessera
