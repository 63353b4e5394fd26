#pragma once

#include "renderer/scene/scene.h"

namespace tessera {

/// SceneFeatures::simple of a scene that is built otherwise. `is_clear`: something of it may let
/// light through.
bool has_simple_features(const Scene& scene, bool is_clear);

}  // namespace tessera
