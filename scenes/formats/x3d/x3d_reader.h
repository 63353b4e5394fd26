#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads X3D's XML encoding (ISO/IEC 19776-1), versions 3.0 to 4.1; what is read and how is in
/// docs/scenes.md. Throws scene_error with the place. Reads no other file.
LoadedScene read_x3d(const std::string& path, const ReadOptions& options);
LoadedScene parse_x3d(std::string_view text, const std::string& name, const ReadOptions& options);

}  // namespace tessera
