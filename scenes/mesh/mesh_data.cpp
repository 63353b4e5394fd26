#include "scenes/mesh/mesh_data.h"

#include <algorithm>
#include <bit>
#include <cmath>
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

size_t replace_endless(std::vector<float>& rows, size_t width, float instead) {
  size_t found = 0;
  for (size_t at = 0; at + width <= rows.size(); at += width) {
    float* const row = &rows[at];
    if (std::all_of(row, row + width, [](float number) { return std::isfinite(number); })) continue;
    std::fill_n(row, width, instead);
    ++found;
  }
  return found;
}

size_t drop_unplaced(MeshData& mesh) {
  constexpr size_t kCorners = 3;
  const auto is_placed = [&](uint32_t vertex) {
    const float* const p = &mesh.positions[size_t{vertex} * 3];
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
  };
  size_t kept = 0;
  const size_t count = mesh.triangle_count();
  for (size_t t = 0; t < count; ++t) {
    const uint32_t* const corners = &mesh.triangles[t * kCorners];
    if (!std::all_of(corners, corners + kCorners, is_placed)) continue;
    if (kept != t) {
      std::copy_n(corners, kCorners, &mesh.triangles[kept * kCorners]);
      if (!mesh.face_materials.empty()) mesh.face_materials[kept] = mesh.face_materials[t];
    }
    ++kept;
  }
  mesh.triangles.resize(kept * kCorners);
  if (!mesh.face_materials.empty()) mesh.face_materials.resize(kept);
  replace_endless(mesh.positions, 3, 0);
  return count - kept;
}

v1::TriangleMesh store_mesh(MeshData mesh, BlobStore& blobs) {
  v1::TriangleMesh out;
  store(mesh.positions, blobs, out.mutable_positions());
  store(mesh.triangles, blobs, out.mutable_triangles());
  if (!mesh.normals.empty()) store(mesh.normals, blobs, out.mutable_normals());
  if (!mesh.uvs.empty()) store(mesh.uvs, blobs, out.mutable_uvs());
  if (!mesh.second_uvs.empty()) store(mesh.second_uvs, blobs, out.mutable_second_uvs());
  if (!mesh.colors.empty()) store(mesh.colors, blobs, out.mutable_colors());
  if (!mesh.tangents.empty()) store(mesh.tangents, blobs, out.mutable_tangents());
  if (!mesh.face_materials.empty()) store(mesh.face_materials, blobs, out.mutable_face_materials());
  return out;
}

}  // namespace tessera
