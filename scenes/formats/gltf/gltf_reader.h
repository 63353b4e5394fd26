#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a glTF 2.0 file, .gltf or .glb, with the buffers that it names inside its own folder. A
/// mesh that several nodes show is one object; lights and cameras stand in the world's frame. What
/// is read of the format and its extensions is in docs/scenes.md. Throws scene_error with the
/// place.
LoadedScene read_gltf(const std::string& path, const ReadOptions& options = {});
/// The same from memory; other files are not read.
LoadedScene parse_gltf(std::string_view bytes, const std::string& name);

}  // namespace tessera
