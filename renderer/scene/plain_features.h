#pragma once

#include "renderer/scene/scene.h"

namespace tessera {

/// SceneFeatures::plain of a scene that is built otherwise.
bool has_plain_features(const Scene& scene);

}  // namespace tessera
