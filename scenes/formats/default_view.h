#pragma once

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Gives a model that has no camera and no light a three-quarter view of all of it from the front,
/// a key light over the camera's shoulder with two weaker ones, and a quiet background. Only meshes
/// and nodes without transform are looked at, which is what the readers of plain models make.
void add_default_view(LoadedScene& loaded);

}  // namespace tessera
