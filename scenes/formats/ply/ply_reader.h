#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a PLY file (Turk 1994; text, binary little-endian and big-endian) as one node with one
/// mesh; cameras and lights are for the caller to add. Throws scene_error with the place.
LoadedScene read_ply(const std::string& path);
/// The same from memory.
LoadedScene parse_ply(std::string_view bytes, const std::string& name);

}  // namespace tessera
