#pragma once

#include <filesystem>
#include <string>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Why the picture that a file of `folder` calls `name` is left out, as in "picture 'x.png' is not
/// there"; empty where it is read. Without `check` it need only be there.
std::string picture_problem(const std::filesystem::path& folder, const std::string& name,
                            const PictureCheck& check);

}  // namespace tessera
