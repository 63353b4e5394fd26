#pragma once

#include <memory>

#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

struct Scene;

/// Builds what rendering the scene by these options needs, and throws what that would throw.
std::shared_ptr<const Scene> check_buildable(const RenderOptions& options,
                                             const LoadedScene& loaded);

}  // namespace tessera
