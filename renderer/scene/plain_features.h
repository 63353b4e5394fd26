#pragma once

#include "renderer/scene/scene.h"

namespace tessera {

/// Sets SceneFeatures::plain and simple of a scene that is built otherwise. `is_clear`: something
/// of it may let light through.
void find_plain_features(Scene& scene, bool is_clear);

}  // namespace tessera
