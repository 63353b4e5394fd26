#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a PLY file (Turk 1994; text, binary little-endian and big-endian) as one node with one
/// mesh; cameras and lights are for the caller to add. Throws scene_error with the place.
LoadedScene read_ply(const std::string& path);
/// The same from memory; `has_picture` says whether a picture of that relative path may be read and
/// is there, without it every one is.
LoadedScene parse_ply(std::string_view bytes, const std::string& name,
                      const std::function<bool(const std::string& path)>& has_picture = {});

}  // namespace tessera
