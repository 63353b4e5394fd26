#pragma once

#include <string>
#include <vector>

#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// What of the pictures asked for will hardly be what was meant: all of them black, or all the
/// same.
std::vector<std::string> picture_warnings(const RenderOptions& options, const LoadedScene& loaded);
/// What the files that they go to will not hold.
std::vector<std::string> file_warnings(const RenderOptions& options, const LoadedScene& loaded);

}  // namespace tessera
