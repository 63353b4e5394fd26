#pragma once

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Gives a model what it came without: a three-quarter view of all its meshes from the front, a key
/// light over the camera's shoulder with two weaker ones, a studio around it and some samples a
/// pixel; a camera of its own within it gets a light. `z_is_up`: the model stands along the z axis,
/// else along y. With ReadOptions::environment it gets no lights.
void add_default_view(LoadedScene& loaded, bool z_is_up, const ReadOptions& options);

}  // namespace tessera
