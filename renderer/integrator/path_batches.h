#pragma once

#include <memory>
#include <string_view>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/integrator/batch_tracer.h"

namespace tessera {

/// Batches of paths through a scene, bounce by bounce, by the instructions of the set that
/// BvhKernels of that name are of. `scene` must outlive it. The keys tell the rays' cones too.
///
/// Numbers are drawn, rays traced and, where light is scattered evenly, directions and weights
/// worked out of as many paths as a vector holds. The counts are those of single paths but those of
/// traversal and, where some surfaces scatter otherwise or have one side, of numbers, of roulette
/// and of shadow rays left out where a texture is black.
std::unique_ptr<const BatchTracer> make_path_batches(
    const Scene& scene, std::string_view instructions = kernels().name);

}  // namespace tessera
