#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads an STL file (3D Systems 1989; text and binary) as one node with one mesh of flat
/// triangles; cameras and lights are for the caller to add. Corners at equal positions share a
/// vertex. Which side is the front is said by the order of the corners alone. Throws scene_error
/// with the place.
LoadedScene read_stl(const std::string& path);
/// The same from memory.
LoadedScene parse_stl(std::string_view bytes, const std::string& name);

}  // namespace tessera
