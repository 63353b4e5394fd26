#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "scenes/formats/x3d/document/x3d_values.h"
#include "scenes/mesh/pen.h"

namespace tessera {

/// What a polygon node becomes: a mesh, and what its shape's material has to know.
struct X3dMesh {
  v1::TriangleMesh mesh;
  bool has_colors = false;
  bool has_color_alpha = false;  ///< which takes the place of the material's transparency
  bool empty = false;            ///< no face that could be seen
};

/// Whether nodes of that type become meshes.
bool is_x3d_mesh(std::string_view type);
/// Whether they are lines or points, which no light falls on.
bool is_x3d_lines(std::string_view type);

/// The nodes with polygons, grids, extrusions, text, lines and points.
struct X3dMeshOptions {
  bool linear = false;    ///< vertex colours are decoded from sRGB
  double weld = 0;        ///< points this near are one to made normals, in the node's units
  bool textured = false;  ///< texture coordinates are made where the node has none
  Pen pen{};              ///< of lines and points
};
/// Throws scene_error naming the node and the face.
X3dMesh build_x3d_mesh(const X3dNode& node, const X3dValues& values, const X3dMeshOptions& options,
                       BlobStore& blobs);

}  // namespace tessera
