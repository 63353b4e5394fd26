#include "scenes/mesh/mesh_data.h"

#include <bit>
#include <cstring>
#include <span>
#include <utility>

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "blobs are little-endian");

template <typename T>
void store(std::vector<T>& values, BlobStore& blobs, v1::BlobRef* ref) {
  const auto bytes = std::as_bytes(std::span(values));
  ref->set_size(bytes.size());
  std::vector<std::byte> blob(bytes.begin(), bytes.end());
  values = {};
  ref->set_digest(blobs.put(std::move(blob)).hex());
}

}  // namespace

v1::TriangleMesh store_mesh(MeshData mesh, BlobStore& blobs) {
  v1::TriangleMesh out;
  store(mesh.positions, blobs, out.mutable_positions());
  store(mesh.triangles, blobs, out.mutable_triangles());
  if (!mesh.normals.empty()) store(mesh.normals, blobs, out.mutable_normals());
  if (!mesh.uvs.empty()) store(mesh.uvs, blobs, out.mutable_uvs());
  if (!mesh.colors.empty()) store(mesh.colors, blobs, out.mutable_colors());
  if (!mesh.face_materials.empty()) store(mesh.face_materials, blobs, out.mutable_face_materials());
  return out;
}

}  // namespace tessera
