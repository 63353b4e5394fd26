#pragma once

#include <memory>
#include <string_view>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/integrator/row_tracer.h"

namespace tessera {

/// Whether paths through the scene can be followed in rows: something to hit, no fog, and no veils
/// where the camera sees up to some distance only; with Skips' absent_features and texture_points.
bool can_follow_paths(const Scene& scene);
/// Rows of paths through such a scene, bounce by bounce, by the instructions of the set that
/// BvhKernels of that name are of. `scene` must outlive it. The keys tell the rays' cones too.
///
/// Numbers are drawn, rays traced and, where light is scattered evenly, directions and weights
/// worked out of as many paths as a vector holds. The counts are those of single paths but those of
/// traversal and, where some surfaces scatter otherwise or have one side, of numbers, of roulette
/// and of shadow rays left out where a texture is black.
std::unique_ptr<const RowTracer> make_path_rows(const Scene& scene,
                                                std::string_view instructions = kernels().name);

}  // namespace tessera
