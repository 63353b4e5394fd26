#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenes/formats/x3d/document/x3d_values.h"
#include "scenes/formats/x3d/geometry/x3d_polygons.h"
#include "scenes/mesh/crease_normals.h"

namespace tessera {

/// The faces of a geometry node before colours and normals are looked at.
struct X3dFaces {
  std::vector<float> points;  ///< x y z each
  Polygons polygons;          ///< corners are indices of points
  /// Where each corner is in the list that is indexed by corner; -1 marks between faces count.
  std::vector<uint32_t> corner_slots;
  /// The number in the file of each face, since faces that show nothing are left out.
  std::vector<uint32_t> numbers;
  /// The coordinate that each corner stands for, where that is not its point.
  std::vector<uint32_t> corner_coordinates;
  /// Texture coordinates where the node gives none, with the index of each corner's; else empty:
  /// those of the bounding box.
  std::vector<float> uvs;
  std::vector<uint32_t> corner_uvs;

  void add_face(std::span<const uint32_t> face);
};

/// The most points that a node may turn out to have.
inline constexpr size_t kMaxX3dPoints = size_t{1} << 24;

/// Reads the index of a polygon node, or counts through its coordinates, and drops faces with
/// fewer than three different points. Every index is below the number of points.
X3dFaces read_x3d_polygons(const X3dNode& node, const X3dValues& values);
/// ElevationGrid: a quad a cell, row by row in +z.
X3dFaces read_x3d_grid(const X3dNode& node, const X3dValues& values);
/// Extrusion: a quad for each side of the cross-section a step of the spine, then the caps, whose
/// points are their own so that no crease angle smooths over their rim.
X3dFaces read_x3d_extrusion(const X3dNode& node, const X3dValues& values);
/// Text: flat lines of our own stroke font, in the plane z = 0.
X3dFaces read_x3d_text(const X3dNode& node, const X3dValues& values);
/// IndexedLineSet, LineSet and PointSet, drawn by the pen.
X3dFaces read_x3d_lines(const X3dNode& node, const X3dValues& values, const Pen& pen);

}  // namespace tessera
