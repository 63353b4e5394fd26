#pragma once

#include "renderer/film/tile.h"
#include "renderer/render/hidden_light.h"
#include "renderer/render/sample_tracer.h"
#include "renderer/render/tile_state.h"
#include "renderer/render/tile_writer.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// Renders a tile by adaptive sampling: each block that it has pixels of until that has converged
/// (BlockEstimate), or has all samples of the task. `false` where it was cancelled.
bool render_adaptively(const Scene& scene, const SampleTracer& tracer, const HiddenLight& hidden,
                       const RenderTask& task, TileState& state, TileWriter& writer);

}  // namespace tessera
