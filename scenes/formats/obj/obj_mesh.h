#pragma once

#include <cstdint>
#include <vector>

#include "scenes/mesh/mesh_data.h"
#include "scenes/mesh/vertex_table.h"

namespace tessera {

/// The vertex data of an OBJ file as they are read, and the triangles over them. Each different
/// (position, texture coordinate, normal) that a face uses becomes one vertex of the mesh.
class ObjMesh {
 public:
  /// In place of a normal's index: to be generated, one for each position and smoothing group.
  static constexpr uint32_t kFirstSmoothingGroup = 0x80000000;
  static constexpr uint32_t kMostSmoothingGroups = 0x7FFFFFFE;
  /// More of anything than this is refused, so that indices fit.
  static constexpr size_t kMaxElements = 0x7FFFFFFF;

  std::vector<float> positions;  ///< x y z each
  std::vector<float> colors;     ///< r g b a each; empty while no position has one
  std::vector<float> uvs;        ///< u v each
  std::vector<float> normals;    ///< x y z each
  std::vector<uint32_t> face_materials;

  size_t position_count() const { return positions.size() / 3; }
  size_t triangle_count() const { return triangles_.size() / 3; }

  /// A corner's normal may be kFirstSmoothingGroup + group, or kNoIndex for the face's own.
  void add_triangle(const MeshCorner& a, const MeshCorner& b, const MeshCorner& c);
  /// Generates the normals that are asked for and gives the mesh away; this is empty afterwards.
  MeshData finish();

 private:
  void split_flat_faces();
  std::vector<float> vertex_normals() const;

  VertexTable vertices_;
  std::vector<uint32_t> triangles_;
};

}  // namespace tessera
