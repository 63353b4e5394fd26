#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads an OBJ file and the MTL files beside it as one node with one mesh; cameras and lights are
/// for the caller to add. Throws scene_error with the place.
LoadedScene read_obj(const std::string& path, const ReadOptions& options = {});
/// The same from memory; material libraries are not looked for.
LoadedScene parse_obj(std::string_view text, const std::string& name);

}  // namespace tessera
