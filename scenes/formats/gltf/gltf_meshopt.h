#pragma once

#include <string>
#include <string_view>

#include "scenes/formats/gltf/gltf_file.h"

namespace tessera {

/// The rows of a buffer view that has them as `packed` by `extension`, its
/// EXT_meshopt_compression. Throws where they are not what that says.
std::string unpack_meshopt(GltfFile& file, const GltfValue& extension, std::string_view packed);

}  // namespace tessera
