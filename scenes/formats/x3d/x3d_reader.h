#pragma once

#include <string>
#include <string_view>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads X3D 3.0 to 4.1 in the XML and classic encodings (ISO/IEC 19776-1, -2) and VRML97, plain or
/// gzipped, told apart by their first bytes; what is read and how is in docs/scenes.md. Throws
/// scene_error with the place. Of other files only those in the folder of `path` are read, which
/// Inlines name; those of other formats, and pictures, are left for the caller as includes and as
/// textures that name files.
LoadedScene read_x3d(const std::string& path, const ReadOptions& options);
/// The same for a file's bytes, whose Inlines are left out.
LoadedScene parse_x3d(std::string_view bytes, const std::string& name, const ReadOptions& options);

}  // namespace tessera
