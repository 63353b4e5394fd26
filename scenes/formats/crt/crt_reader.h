#pragma once

#include <string>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Runs a script of CRT (Haiken, HEIG-VD 2015) and returns the scene that it describes; docs/crt.md
/// is the language as it is read here. options.frame is the value of t. Throws one scene error that
/// holds all that is wrong, each with its place, source line and caret.
LoadedScene read_crt(const std::string& path, const ReadOptions& options);

/// As read_crt, of a script in memory; files that it names must lie in `folder`, and are not looked
/// for where that is empty.
LoadedScene parse_crt(const std::string& text, const std::string& name, const std::string& folder,
                      int32_t frame);

}  // namespace tessera
