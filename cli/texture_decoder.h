#pragma once

#include <string>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a picture for a scene, up to four channels of it and without loss. Throws scene_error.
DecodedTexture decode_texture(const std::string& path);

}  // namespace tessera
