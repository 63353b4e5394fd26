#pragma once

#include <optional>
#include <string>

#include "scenes/import/asset_folder.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Runs a script of CRT (Haiken, HEIG-VD 2015) and returns the scene that it describes; docs/crt.md
/// is the language as it is read here. options.frame is the value of t. Throws one scene error that
/// holds all that is wrong, each with its place, source line and caret.
LoadedScene read_crt(const std::string& path, const ReadOptions& options);

/// As read_crt, of a script in memory; without `assets` the files that it names are not looked for.
LoadedScene parse_crt(const std::string& text, const std::string& name,
                      const std::optional<AssetFolder>& assets, int32_t frame,
                      bool keep_origins = false);

}  // namespace tessera
