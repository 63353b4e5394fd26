#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/shape.h"

namespace tessera {

struct Float2 {
  float x = 0, y = 0;
};
struct Float3 {
  float x = 0, y = 0, z = 0;
};
struct Float4 {
  float x = 0, y = 0, z = 0, w = 0;
};
static_assert(sizeof(Float3) == 12 && sizeof(Float4) == 16, "laid out as in the scene's blobs");

using TriangleIndices = std::array<uint32_t, 3>;

/// Triangles by index into shared vertices, counter-clockwise seen from the front. The optional
/// arrays are empty where the scene has no use for them.
struct TriangleMesh {
  std::vector<Float3> positions;
  std::vector<TriangleIndices> triangles;
  std::vector<Float3> normals;           ///< one a vertex; any length but 0
  std::vector<Float2> uvs;               ///< one a vertex
  std::vector<Float2> second_uvs;        ///< one a vertex
  std::vector<Float4> colors;            ///< one a vertex: linear RGBA
  std::vector<Float4> tangents;          ///< one a vertex; w is the side of the bitangent
  std::vector<uint32_t> face_materials;  ///< one a triangle
  /// Where drop_degenerate() took some away: the number that each triangle had before, ascending.
  std::vector<uint32_t> original_numbers;

  Point3 vertex(uint32_t index) const {
    const Float3& p = positions[index];
    return {p.x, p.y, p.z};
  }
  std::array<Point3, 3> corners(size_t triangle) const {
    const TriangleIndices& i = triangles[triangle];
    return {vertex(i[0]), vertex(i[1]), vertex(i[2])};
  }
  Bounds3 bounds() const;
  size_t bytes() const;
};

/// Triangles that drop_degenerate() took away, by reason.
struct MeshDefects {
  size_t bad_index = 0, not_finite = 0;
  size_t coincident = 0;  ///< two corners at one place
  size_t total() const { return bad_index + not_finite + coincident; }
};

/// Removes every triangle that no accelerator may hold, with its face material; keeps the order of
/// the rest. Three distinct corners in a line stay: without them a closed mesh would have a slit.
MeshDefects drop_degenerate(TriangleMesh& mesh, int threads = 1);

/// Whether every edge is passed as often one way as the other. Vertices at the same place count as
/// one.
bool is_closed(const TriangleMesh& mesh);
/// As Shape::crossing_number. A ray right through an edge or vertex is moved aside by an endlessly
/// small step, the same for all triangles: so a line through a closed mesh crosses it as often in
/// as out, and never twice at a shared edge.
int mesh_crossing_number(const TriangleMesh& mesh, const Ray& ray, std::span<const Hit> hits);

/// The surface at barycentric weights u, v of vertices 1 and 2 of a triangle.
LocalSurface triangle_surface(const TriangleMesh& mesh, uint32_t triangle, double u, double v);

}  // namespace tessera
