#pragma once

#include <span>
#include <vector>

#include "renderer/accel/box_soa.h"
#include "renderer/accel/instance.h"
#include "renderer/accel/instance_soa.h"
#include "renderer/accel/plane_soa.h"
#include "renderer/accel/ray_batch.h"
#include "renderer/accel/rectangle_soa.h"
#include "renderer/accel/spatial_splits.h"
#include "renderer/accel/traversal_tree.h"
#include "renderer/accel/wide_tree.h"
#include "renderer/shapes/ray.h"
#include "renderer/shapes/shape.h"
#include "renderer/shapes/triangle.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// Four triangles: vertex, axis, lane. Unused lanes hold NaN, which no ray hits. A leaf is a run of
/// blocks; the last number of its last block is marked.
struct alignas(32) TriangleBlock {
  static constexpr uint32_t kLast = 0x80000000u;
  static constexpr uint32_t kNone = 0x7fffffffu;

  float vertex[3][3][4];
  uint32_t primitive[4];
};
static_assert(sizeof(TriangleBlock) == 5 * sizeof(TreeUnit));

struct MeshTree {
  TraversalTree tree;
  Bounds3 bounds;
  CutPlanes cut_planes;  ///< of triangles that are in several leaves
};

struct InstanceTree {
  TraversalTree tree;  ///< leaves are those of the WideTree, over `slots`
  std::vector<uint32_t> slots;
  std::vector<Instance> instances;
  std::vector<uint32_t> endless;  ///< that it cannot hold, always tested; in ascending order
  Bounds3 tree_bounds;            ///< of those inside
};

inline constexpr size_t kPacketSize = 32;

/// Traversal compiled for each instruction set; `kernels()` is the best that this machine has, or
/// that which TESSERA_SIMD names in the environment (usage_error where this machine has it not).
/// All return the same bits.
struct BvhKernels {
  bool (*mesh_closest)(const MeshTree&, const Ray&, Hit&, TraversalCounters&);
  bool (*mesh_any)(const MeshTree&, const Ray&, TraversalCounters&);
  /// Appends all hits, some perhaps twice.
  void (*mesh_all)(const MeshTree&, const Ray&, std::vector<Hit>&, TraversalCounters&);
  /// mesh_closest for each of up to kPacketSize rays that go much the same way; false, with nothing
  /// done, where they do not or cannot be traced together.
  bool (*mesh_closest_packet)(const MeshTree&, std::span<const Ray>, std::span<Hit>,
                              TraversalCounters&);
  /// mesh_any of such rays, a bit each into `hit`.
  bool (*mesh_any_packet)(const MeshTree&, std::span<const Ray>, uint32_t& hit, TraversalCounters&);
  /// The exact test of the leaf that begins at unit `leaf`, for a valid ray.
  bool (*leaf_closest)(const MeshTree&, uint32_t leaf, const TriangleRay&, Hit&,
                       TraversalCounters&);
  bool (*leaf_any)(const MeshTree&, uint32_t leaf, const TriangleRay&, TraversalCounters&);
  void (*leaf_all)(const MeshTree&, uint32_t leaf, const TriangleRay&, std::vector<Hit>&,
                   TraversalCounters&);
  bool (*instance_closest)(const InstanceTree&, const Ray&, Hit&, TraversalCounters&);
  /// As Accelerator::any_hit_by().
  bool (*instance_any)(const InstanceTree&, const Ray&, uint32_t& first, TraversalCounters&);
  /// Appends all hits, some perhaps twice.
  void (*instance_all)(const InstanceTree&, const Ray&, std::vector<Hit>&, TraversalCounters&);
  /// As those of meshes.
  bool (*instance_closest_packet)(const InstanceTree&, std::span<const Ray>, std::span<Hit>,
                                  TraversalCounters&);
  bool (*instance_any_packet)(const InstanceTree&, std::span<const Ray>, uint32_t& hit,
                              TraversalCounters&);
  /// Which of `boxes` the ray may enter before `t_max`, a bit each, and lower bounds of t there, as
  /// many as boxes.count. For a ray that can_hit().
  uint32_t (*boxes_entered)(const BoxSoA& boxes, const Ray& ray, double t_max, double* entered);
  /// Which of `rectangles` the ray may hit before `t_max`, and lower bounds of t there.
  RectanglesMet (*rectangles_met)(const RectangleSoA& rectangles, const Ray& ray, double t_max,
                                  double* entered);
  /// Which of `planes` the ray meets at t <= `limit`, a bit each, and t, as many as planes.count
  /// rounded up to four; ray.cull does not count.
  uint32_t (*planes_met)(const PlaneSoA& planes, const Ray& ray, double limit, double* t);
  /// What each of the rays meets of what can be held against many at once, and the boxes that it
  /// may hit something in before.
  void (*intersect_batch)(const InstanceSoA& few, const RayBatch& rays, bool only_shading,
                          BatchHits& met);
  const char* name;
};

const BvhKernels& kernels();
/// Those that count the same visits on every x86 machine. All find the same hits, but not by the
/// same visits: boxes that a ray all but grazes are entered or not by whether products are rounded.
const BvhKernels& common_kernels();
/// One entry for each instruction set that this machine has, the best first.
std::span<const BvhKernels> all_kernels();

}  // namespace tessera
