#pragma once

#include <cstddef>
#include <vector>

#include "renderer/accel/wide_tree.h"
#include "renderer/shapes/ray.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

// Spatial splits (Stich, Friedrich and Dietrich, HPG 2009), done before the build: large triangles
// askew to the axes are cut in pieces, each with a box of its own, wherever a plane divides a node
// at less cost than any division of whole triangles; the tree is then built over the pieces. A
// triangle may so be tested more than once, which changes no hit.
//
// Where a triangle is seen almost edge-on, its t is known badly and may be told anywhere in its box
// (settle_uncertain_t() in triangle.h), far from the piece that the ray crosses. So only triangles
// of few directions are cut, and a ray that grazes one of these directions is known before it is
// traced: it visits every box on its line, whatever it has hit already. For all other rays t is
// true to 2^-21 of the scene, half of what the boxes' margin has left: with vertices at most E from
// the origin on each axis, the ray's origin at most 4 E, the triangle's area at least E^2 / 256 and
// the sine between ray and plane at least 2^-10, rounding moves t by less than 20 * 2^-30 E.

/// Directions of the planes of triangles that were cut.
struct CutPlanes {
  static constexpr int kMost = 8;
  int count = 0;
  double normal[3][kMost] = {};  ///< unit; those behind `count` repeat one before

  /// Whether the ray must visit every box on its line. `extent` is that of the tree.
  bool must_visit_all(const Ray& ray, double extent) const;
};

struct SpatialSplits {
  std::vector<BuildBox> boxes;  ///< at most kMaxGrowth times as many as the triangles
  CutPlanes planes;
};
inline constexpr double kMaxGrowth = 1.3;

/// `boxes` are triangle_boxes(mesh), which come back as they are where nothing is worth cutting.
/// O(n log n), on the calling thread alone.
SpatialSplits split_spatially(const TriangleMesh& mesh, std::vector<BuildBox> boxes);

}  // namespace tessera
