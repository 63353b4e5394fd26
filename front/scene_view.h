#pragma once

#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Whether --view or --turntable puts a camera in place of the scene's.
bool brings_camera(const RenderOptions& options);

/// Throws usage_error where one of these is beside --camera.
void check_view(const RenderOptions& options);

/// Puts the camera that they ask for in place of the scene's, whose first one's headlight it keeps.
/// Up is where --up says, else z where the first camera's look_at says so, else y. --turntable
/// goes around what there is in the first frame; it builds the scene, and throws what that throws.
void use_view(const RenderOptions& options, LoadedScene& loaded);

}  // namespace tessera
