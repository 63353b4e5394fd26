#pragma once

#include <string>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Where `scene` is "-": reads standard input to its end, which `reading` then has as the text of a
/// file "stdin" in the current folder, and `scene` becomes that name. Throws scene_error where it
/// cannot be read, or is larger than any scene is expected to be.
void take_standard_input(std::string& scene, ReadOptions& reading);

}  // namespace tessera
