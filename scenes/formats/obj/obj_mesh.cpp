#include "scenes/formats/obj/obj_mesh.h"

#include <algorithm>
#include <array>
#include <utility>

#include "renderer/math/vec.h"

namespace tessera {
namespace {

void put_unit(const Vec3& v, float* out) {
  const Vec3 unit = v == Vec3{} ? Vec3{0, 0, 1} : normalize(v);
  for (int a = 0; a < 3; ++a) out[a] = static_cast<float>(unit[a]);
}

}  // namespace

void ObjMesh::add_triangle(const MeshCorner& a, const MeshCorner& b, const MeshCorner& c) {
  triangles_.push_back(vertices_.add(a));
  triangles_.push_back(vertices_.add(b));
  triangles_.push_back(vertices_.add(c));
}

/// Where some faces have normals, the others need vertices of their own to stay flat.
void ObjMesh::split_flat_faces() {
  for (size_t t = 0; t < triangles_.size(); t += 3) {
    std::array<Vec3, 3> p;
    bool flat = false;
    for (size_t i = 0; i < 3; ++i) {
      const MeshCorner& corner = vertices_[triangles_[t + i]];
      p[i] = vec_at(positions, size_t{3} * corner.position);
      flat |= corner.normal == kNoIndex;
    }
    if (!flat) continue;
    const auto normal = static_cast<uint32_t>(normals.size() / 3);
    normals.resize(normals.size() + 3);
    put_unit(cross(p[1] - p[0], p[2] - p[0]), &normals[size_t{normal} * 3]);
    for (size_t i = t; i < t + 3; ++i) {
      MeshCorner corner = vertices_[triangles_[i]];
      corner.normal = normal;
      triangles_[i] = vertices_.add_apart(corner);
    }
  }
}

/// Generated normals are the sums of their faces' area vectors, kept at a group's first vertex.
std::vector<float> ObjMesh::vertex_normals() const {
  const auto is_generated = [&](uint32_t vertex) {
    const uint32_t normal = vertices_[vertex].normal;
    return normal != kNoIndex && normal >= kFirstSmoothingGroup;
  };
  std::vector<Vec3> sums;
  for (size_t t = 0; t < triangles_.size(); t += 3) {
    if (!is_generated(triangles_[t])) continue;
    sums.resize(vertices_.size());
    std::array<Vec3, 3> p;
    for (size_t i = 0; i < 3; ++i)
      p[i] = vec_at(positions, size_t{3} * vertices_[triangles_[t + i]].position);
    const Vec3 area = cross(p[1] - p[0], p[2] - p[0]);
    for (size_t i = t; i < t + 3; ++i) {
      Vec3& sum = sums[vertices_.leader(triangles_[i])];
      sum = sum + area;
    }
  }
  std::vector<float> out(vertices_.size() * 3);
  for (uint32_t v = 0; v < vertices_.size(); ++v) {
    // A vertex that only flat faces had is no longer used.
    if (vertices_[v].normal == kNoIndex)
      put_unit({}, &out[size_t{v} * 3]);
    else
      put_unit(is_generated(v) ? sums[vertices_.leader(v)]
                               : vec_at(normals, size_t{3} * vertices_[v].normal),
               &out[size_t{v} * 3]);
  }
  return out;
}

MeshData ObjMesh::finish() {
  MeshData mesh;
  if (vertices_.any(&MeshCorner::normal)) {
    split_flat_faces();
    mesh.normals = vertex_normals();
  }
  normals = {};
  mesh.positions = vertices_.gather(positions, 3, &MeshCorner::position);
  positions = {};
  if (!colors.empty()) mesh.colors = vertices_.gather(colors, 4, &MeshCorner::position);
  colors = {};
  if (vertices_.any(&MeshCorner::uv)) mesh.uvs = vertices_.gather(uvs, 2, &MeshCorner::uv);
  uvs = {};
  vertices_ = {};
  mesh.triangles = std::move(triangles_);
  mesh.face_materials = std::move(face_materials);
  return mesh;
}

}  // namespace tessera
