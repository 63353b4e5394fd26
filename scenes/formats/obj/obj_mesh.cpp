#include "scenes/formats/obj/obj_mesh.h"

#include <algorithm>
#include <utility>

#include "renderer/math/vec.h"

namespace tessera {
namespace {

Vec3 vec_at(const std::vector<float>& values, size_t index) {
  return {values[3 * index], values[3 * index + 1], values[3 * index + 2]};
}

void put_unit(const Vec3& v, float* out) {
  const Vec3 unit = v == Vec3{} ? Vec3{0, 0, 1} : normalize(v);
  for (int a = 0; a < 3; ++a) out[a] = static_cast<float>(unit[a]);
}

/// One value of `width` numbers for each vertex, by the index that `select` takes from its corner.
template <typename Vertices, typename Select>
std::vector<float> gather(const std::vector<float>& from, int width, const Vertices& vertices,
                          Select select) {
  std::vector<float> out(vertices.size() * width, 0.f);
  for (size_t i = 0; i < vertices.size(); ++i) {
    const uint32_t index = select(vertices[i].corner);
    if (index == ObjMesh::kNone) continue;
    std::copy_n(from.begin() + static_cast<ptrdiff_t>(size_t{index} * width), width,
                out.begin() + static_cast<ptrdiff_t>(i * width));
  }
  return out;
}

}  // namespace

uint32_t ObjMesh::vertex(const Corner& corner) {
  if (first_vertex_.size() < position_count()) first_vertex_.resize(position_count(), kNone);
  uint32_t* link = &first_vertex_[corner.position];
  while (*link != kNone) {
    Vertex& known = vertices_[*link];
    if (known.corner == corner) return *link;
    link = &known.next;
  }
  const auto id = static_cast<uint32_t>(vertices_.size());
  *link = id;
  vertices_.push_back({corner, kNone});
  return id;
}

void ObjMesh::add_triangle(const Corner& a, const Corner& b, const Corner& c) {
  triangles_.push_back(vertex(a));
  triangles_.push_back(vertex(b));
  triangles_.push_back(vertex(c));
}

bool ObjMesh::has_normals() const {
  return std::any_of(vertices_.begin(), vertices_.end(),
                     [](const Vertex& v) { return v.corner.normal != kNone; });
}

/// Where some faces have normals, the others need vertices of their own to stay flat.
void ObjMesh::split_flat_faces() {
  for (size_t t = 0; t < triangles_.size(); t += 3) {
    uint32_t flat = kNone;
    for (size_t i = t; i < t + 3; ++i) {
      Corner corner = vertices_[triangles_[i]].corner;
      if (corner.normal != kNone) continue;
      if (flat == kNone) {
        const Vec3 p = vec_at(positions, vertices_[triangles_[t]].corner.position);
        const Vec3 q = vec_at(positions, vertices_[triangles_[t + 1]].corner.position);
        const Vec3 r = vec_at(positions, vertices_[triangles_[t + 2]].corner.position);
        flat = static_cast<uint32_t>(normals.size() / 3);
        normals.resize(normals.size() + 3);
        put_unit(cross(q - p, r - p), &normals[size_t{flat} * 3]);
      }
      corner.normal = flat;
      triangles_[i] = static_cast<uint32_t>(vertices_.size());
      vertices_.push_back({corner, kNone});
    }
  }
}

std::vector<float> ObjMesh::vertex_normals() const {
  // The sum of a position's faces in one smoothing group is kept at its first vertex of that group.
  const auto leader = [&](uint32_t id) {
    const Corner& corner = vertices_[id].corner;
    uint32_t at = first_vertex_[corner.position];
    while (vertices_[at].corner.normal != corner.normal) at = vertices_[at].next;
    return at;
  };
  const bool generate = std::any_of(vertices_.begin(), vertices_.end(), [](const Vertex& v) {
    return v.corner.normal != kNone && v.corner.normal >= kFirstSmoothingGroup;
  });
  std::vector<Vec3> sums(generate ? vertices_.size() : 0);
  for (size_t t = 0; generate && t < triangles_.size(); t += 3) {
    Vec3 p[3];
    for (int i = 0; i < 3; ++i)
      p[i] = vec_at(positions, vertices_[triangles_[t + i]].corner.position);
    const Vec3 area = cross(p[1] - p[0], p[2] - p[0]);
    for (int i = 0; i < 3; ++i) {
      const uint32_t id = triangles_[t + i];
      if (vertices_[id].corner.normal >= kFirstSmoothingGroup) {
        Vec3& sum = sums[leader(id)];
        sum = sum + area;
      }
    }
  }
  std::vector<float> out(vertices_.size() * 3);
  for (uint32_t id = 0; id < vertices_.size(); ++id) {
    const uint32_t normal = vertices_[id].corner.normal;
    put_unit(normal < kFirstSmoothingGroup ? vec_at(normals, normal) : sums[leader(id)],
             &out[size_t{id} * 3]);
  }
  return out;
}

MeshData ObjMesh::finish() {
  MeshData mesh;
  if (has_normals()) {
    split_flat_faces();
    mesh.normals = vertex_normals();
  }
  first_vertex_ = {};
  normals = {};
  mesh.positions = gather(positions, 3, vertices_, [](const Corner& c) { return c.position; });
  positions = {};
  if (!colors.empty())
    mesh.colors = gather(colors, 4, vertices_, [](const Corner& c) { return c.position; });
  colors = {};
  const bool has_uvs = std::any_of(vertices_.begin(), vertices_.end(),
                                   [](const Vertex& v) { return v.corner.uv != kNone; });
  if (has_uvs) mesh.uvs = gather(uvs, 2, vertices_, [](const Corner& c) { return c.uv; });
  uvs = {};
  vertices_ = {};
  mesh.triangles = std::move(triangles_);
  mesh.face_materials = std::move(face_materials);
  return mesh;
}

}  // namespace tessera
