#pragma once

#include <string>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a picture for a scene: 8-bit RGB where the file holds no more, else floats. Throws
/// scene_error.
DecodedTexture decode_texture(const std::string& path);

}  // namespace tessera
