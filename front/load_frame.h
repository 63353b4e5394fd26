#pragma once

#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// The scene as the options ask for it, at that frame of its animation. Throws as read_scene().
LoadedScene load_frame(const RenderOptions& options, int frame);

/// What of the options changes the cameras of a scene: --pinhole and --frame-all.
void apply_camera_options(const RenderOptions& options, v1::Scene& scene);

}  // namespace tessera
