#pragma once

#include "scenes/formats/gltf/gltf_file.h"

namespace tessera {

/// Reads the triangles and vertices that a primitive holds in Draco's form by `extension`, its
/// KHR_draco_mesh_compression, and gives them to the file as what its accessors hold. Throws where
/// they are not what that says.
void unpack_draco(GltfFile& file, const GltfValue& primitive, const GltfValue& extension);

}  // namespace tessera
