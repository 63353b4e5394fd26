#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a PLY file (Turk 1994; text, binary little-endian and big-endian) as one node with one
/// mesh; cameras and lights are for the caller to add. Throws scene_error with the place.
LoadedScene read_ply(const std::string& path, const ReadOptions& options = {});
/// The same from memory; `check` is asked about the picture's name as it is written.
LoadedScene parse_ply(std::string_view bytes, const std::string& name,
                      const PictureCheck& check = {});

}  // namespace tessera
