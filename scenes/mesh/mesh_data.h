#pragma once

#include <cstdint>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/math/vec.h"

namespace tessera {

/// The arrays of v1::TriangleMesh; those that are optional there may be empty here.
struct MeshData {
  std::vector<float> positions;          ///< x y z a vertex
  std::vector<float> normals;            ///< x y z a vertex
  std::vector<float> uvs;                ///< u v a vertex
  std::vector<float> second_uvs;         ///< u v a vertex
  std::vector<float> colors;             ///< r g b a a vertex
  std::vector<float> tangents;           ///< x y z and the bitangent's side a vertex
  std::vector<uint32_t> triangles;       ///< three vertices a triangle
  std::vector<uint32_t> face_materials;  ///< one a triangle

  size_t vertex_count() const { return positions.size() / 3; }
  size_t triangle_count() const { return triangles.size() / 3; }
};

/// The three numbers from `at` on.
inline Vec3 vec_at(const std::vector<float>& rows, size_t at) {
  return {rows[at], rows[at + 1], rows[at + 2]};
}
inline void put_vec(const Vec3& vec, std::vector<float>& rows, size_t at) {
  for (int axis = 0; axis < 3; ++axis)
    rows[at + static_cast<size_t>(axis)] = static_cast<float>(vec[axis]);
}

// What stands for numbers that are not finite, which other programs export now and then: each
// returns how many it found.

/// Rows of `width` numbers become `instead` as a whole: normals 0, for which the face's own stands,
/// texture coordinates 0, colours 1.
size_t replace_endless(std::vector<float>& rows, size_t width, float instead);
/// Triangles with a corner that is nowhere are taken away.
size_t drop_unplaced(MeshData& mesh);

/// Turns the arrays into blobs, freeing each as it goes so that at most one is held twice.
v1::TriangleMesh store_mesh(MeshData mesh, BlobStore& blobs);

}  // namespace tessera
