#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "scenes/import/asset_folder.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Decodes the files that the scene's image textures name, each once, into blobs. Files are
/// where `assets` finds them, or among loaded.pictures, which is empty afterwards. Of the
/// textures in loaded.picture_channels one channel is kept. Without
/// decoders the textures keep their names only. Throws scene_error for files that are missing,
/// outside the folder or no pictures.
void load_textures(LoadedScene& loaded, const AssetFolder& assets, const ReadOptions& options);

}  // namespace tessera
