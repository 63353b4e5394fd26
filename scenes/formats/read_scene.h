#pragma once

#include <string>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Reads a scene file of any known format, with all that it includes. Throws scene_error with the
/// place for whatever is wrong with it. Nothing outside the file's folder, or
/// options.assets, is read.
LoadedScene read_scene(const std::string& path, const ReadOptions& options = {});

/// Throws what read_scene() throws of a file that is missing, or of a format that is not read.
void check_scene_format(const std::string& path, const ReadOptions& options);

/// Reads what a scene that was made, not read, includes, and what is to be placed into it, as if it
/// were a file `name` of the current folder.
void add_files(LoadedScene& made, const std::string& name, const ReadOptions& options);

}  // namespace tessera
