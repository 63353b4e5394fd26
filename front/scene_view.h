#pragma once

#include <string_view>

#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// The --camera that sees everything, as if the scene had none; a camera of the scene that is
/// called so is found by its number.
inline constexpr std::string_view kAutoCamera = "auto";

/// Whether --view, --turntable or --camera auto puts a camera in place of the scene's.
bool brings_camera(const RenderOptions& options);

/// Throws usage_error where --view or --turntable is beside --camera.
void check_view(const RenderOptions& options);

/// Puts the camera that they ask for in place of the scene's, whose first one's headlight it keeps.
/// Up is where --up says, else z where the first camera's look_at says so, else y. --turntable
/// goes around what there is in the first frame; it builds the scene, and throws what that throws.
void use_view(const RenderOptions& options, LoadedScene& loaded);

}  // namespace tessera
