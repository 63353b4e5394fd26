#pragma once

#include <string>

#include "scenes/import/asset_folder.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Why the picture that a scene's file calls `name` is left out, as in "picture 'x.png' is not
/// there"; empty where it is read. Without `check` it need only be there.
/// Where another file is taken for it, load_textures() says so.
std::string picture_problem(const AssetFolder& assets, const std::string& name,
                            const PictureCheck& check);

}  // namespace tessera
