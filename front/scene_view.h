#pragma once

#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Whether --view or --turntable puts a camera in place of the scene's.
bool brings_camera(const RenderOptions& options);

/// Throws usage_error where one of these is beside --camera.
void check_view(const RenderOptions& options);

/// Puts the camera that they ask for in place of the scene's, whose first one's headlight it keeps.
/// Up is where --up says, else where the first camera has it if that is z, else y. --turntable
/// builds the scene, and throws what that throws.
void use_view(const RenderOptions& options, LoadedScene& loaded);

}  // namespace tessera
