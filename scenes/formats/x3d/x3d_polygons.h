#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "scenes/formats/x3d/x3d_values.h"

namespace tessera {

/// What a polygon node becomes: a mesh, and what its shape's material has to know.
struct X3dMesh {
  v1::TriangleMesh mesh;
  bool has_colors = false;
  bool empty = false;  ///< no face that could be seen
};

/// Whether nodes of that type are made of polygons.
bool is_x3d_polygons(std::string_view type);

/// IndexedFaceSet and the triangle and quad families. `linear` decodes vertex colours from sRGB.
/// Throws scene_error naming the node and the face.
X3dMesh build_x3d_mesh(const X3dNode& node, const X3dValues& values, bool linear, BlobStore& blobs);

/// The linear value of an sRGB-encoded one (IEC 61966-2-1).
double linear_from_srgb(double value);

}  // namespace tessera
