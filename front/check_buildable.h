#pragma once

#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Builds what rendering the scene by these options needs, and throws what that would throw.
void check_buildable(const RenderOptions& options, const LoadedScene& loaded);

}  // namespace tessera
