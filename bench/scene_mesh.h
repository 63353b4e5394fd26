#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/shapes/triangle_mesh.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {

/// The mesh's triangles, without degenerate ones.
TriangleMesh to_triangles(const MeshData& mesh);

/// Every triangle of the scene's meshes in world space, without degenerate ones; warns of shapes
/// that are no meshes. Throws a scene error where the scene is wrong or has no triangles.
TriangleMesh mesh_of_scene(const v1::Scene& scene, const BlobStore& blobs);

}  // namespace tessera
