#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenes/generate/octree_scenes.h"

namespace tessera {

/// What the octree study (Hiller 2018) printed for a scene and an octree.
struct PublishedOctree {
  int depth;
  size_t voxels;
  double object_tests_per_ray, node_visits_per_ray, seconds;
};

/// One line of `tessera bench octree`. Counters are of all rays, divided by the number of primary
/// rays, as the study counts them.
struct OctreeBenchRow {
  std::string scene, accelerator;
  int depth = 0;           ///< 1 for a single voxel; of the tree over the objects
  size_t voxels = 0;       ///< leaf voxels, empty ones too; of a BVH its leaves
  size_t references = 0;   ///< of objects from voxels
  size_t bytes = 0;        ///< tree over the objects and trees of their meshes
  int mesh_depth = 0;      ///< of the deepest tree over the triangles of an object
  size_t mesh_voxels = 0;  ///< of all trees over triangles
  double object_tests_per_ray = 0, primitive_tests_per_ray = 0, node_visits_per_ray = 0;
  double build_seconds = 0, trace_seconds = 0, seconds = 0;  ///< one thread's processor
                                                             ///< time; seconds is the sum
  size_t differing_pixels = 0;  ///< from the first accelerator of the run
  bool sampled = false;         ///< only each 16th pixel of each 16th row; trace_seconds scaled up
  std::optional<PublishedOctree> published;
};

struct OctreeBenchOptions {
  /// linear, octree, nonuniform-octree, nonuniform-octree-nlopt, bvh
  std::vector<std::string> accelerators{"octree", "nonuniform-octree", "nonuniform-octree-nlopt",
                                        "bvh", "linear"};
  int width = 1920, height = 1080;
  int rounds = 5;  ///< builds and traces; the fastest of each counts
};

/// The study's experiment on one scene: a primary ray through the centre of each pixel, and from
/// each hit one shadow ray to each light, whichever way the surface faces.
std::vector<OctreeBenchRow> bench_octree(const OctreeScene& scene,
                                         const OctreeBenchOptions& options);

/// Both kinds of text that `tessera bench octree` writes.
std::string octree_table(const std::vector<OctreeBenchRow>& rows);
std::string octree_json(const std::vector<OctreeBenchRow>& rows);

}  // namespace tessera
