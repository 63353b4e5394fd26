#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/scene/check.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// The mesh's arrays, from its blobs or in line, with every count and index checked;
/// `material_count` bounds face_materials.
TriangleMesh read_mesh(const Where& where, const v1::TriangleMesh& mesh, const BlobStore& blobs,
                       size_t material_count, int threads = 1);

}  // namespace tessera
