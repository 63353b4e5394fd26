#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "renderer/math/transform.h"
#include "scenes/formats/gltf/gltf_file.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {

/// What bends the mesh of a node: a skin by its joints as they stand in the file.
struct GltfSkin {
  std::vector<Affine> joints;  ///< from the mesh to the world, one a joint
  Affine rest{};               ///< the same of vertices that no joint moves: the node's own
};

/// JOINTS_n and WEIGHTS_n of a mesh: four of each a vertex.
struct GltfInfluences {
  std::vector<float> joints, weights;
};

/// The world matrix of each joint of a skin times its inverse bind matrix (glTF 2.0 specification,
/// 3.7.3.3); nothing, with a warning, where one of them is not there. `world_of` gives the world
/// matrix of a node, null for one that is not shown.
std::vector<Affine> read_gltf_joints(GltfFile& file, const GltfValue& skin,
                                     const std::function<const Affine*(size_t node)>& world_of);

/// Takes positions, normals and tangents into the world by the weighted mean of the joints'
/// matrices at each vertex. Triangles that this turns inside out change their winding. Every joint
/// with a weight above 0 is one of the skin's, and no weight is below 0.
void bend_mesh(const GltfSkin& skin, const std::vector<GltfInfluences>& influences, MeshData& mesh);

}  // namespace tessera
