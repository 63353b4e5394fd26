#pragma once

#include "front/render_options.h"
#include "proto/wire/scene_codec.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// The scene as the options ask for it, at that frame of its animation. Throws as read_scene().
LoadedScene load_frame(const RenderOptions& options, int frame);

/// The same of a scene that was made, not read, which errors call options.scene. What it includes
/// is read from the current folder, or that of --assets.
LoadedScene load_frame(const RenderOptions& options, const SceneWithBlobs& made, int frame);

/// What of the options changes a scene: --pinhole, --frame-all, --max-depth and --shadows.
void apply_scene_options(const RenderOptions& options, v1::Scene& scene);

}  // namespace tessera
