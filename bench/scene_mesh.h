#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// Every triangle of the scene's meshes in world space, without degenerate ones. Throws a scene
/// error where the scene is wrong or has no triangles.
TriangleMesh mesh_of_scene(const v1::Scene& scene, const BlobStore& blobs);

}  // namespace tessera
