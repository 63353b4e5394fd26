#pragma once

#include <optional>
#include <vector>

#include "renderer/math/transform.h"
#include "scenes/formats/gltf/gltf_file.h"

namespace tessera {

/// The frames in which a node's EXT_mesh_gpu_instancing shows its mesh, in that of the node.
/// Nothing for a node without it and, with a warning, where it cannot be read. A frame that is not
/// finite is left out with a warning.
std::optional<std::vector<Affine>> read_gltf_instances(GltfFile& file, const GltfValue& node);

}  // namespace tessera
