#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a picture for a scene, up to four channels of it and without loss. Throws scene_error.
DecodedTexture decode_texture(const std::string& path, bool to_srgb);
/// The same for a file that is in memory; `name` is what errors call it.
DecodedTexture decode_texture_bytes(std::string_view bytes, const std::string& name);

}  // namespace tessera
