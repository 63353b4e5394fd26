#pragma once

#include <cstdint>
#include <vector>

#include "scenes/formats/x3d/x3d_values.h"
#include "scenes/mesh/crease_normals.h"

namespace tessera {

/// The faces of a polygon node before colours and normals are looked at.
struct X3dFaces {
  Polygons polygons;  ///< corners are indices of coordinates
  /// Where each corner is in the list that is indexed by corner; -1 marks between faces count.
  std::vector<uint32_t> corner_slots;
  /// The number in the file of each face, since faces that show nothing are left out.
  std::vector<uint32_t> numbers;
};

/// Reads the index of any polygon node, or counts through its coordinates, and drops faces with
/// fewer than three different points. Every index is below `coordinates`.
X3dFaces read_x3d_faces(const X3dNode& node, const X3dValues& values, size_t coordinates);

}  // namespace tessera
