#include "renderer/accel/octree.h"

#include "base/monotonic.h"
#include "renderer/accel/tree_boxes.h"

namespace tessera {
namespace {

std::unique_ptr<const SplitSearch> make_search(OctreeKind kind) {
  if (kind == OctreeKind::uniform) return nullptr;
  if (kind == OctreeKind::nonuniform) return std::make_unique<SweepSearch>();
  return make_nlopt_search();
}

}  // namespace

// Found by measuring the study's scenes and scanned meshes. An object in a leaf takes one lane of
// an eight-wide node, so that eight of them cost about what one visit of a node does; and so do
// four blocks of triangles, which need no boxes of their own.

OctreeOptions mesh_octree_options(const SplitSearch* search) {
  return {.search = search,
          .block_size = 4,
          .few_objects = search ? 0u : 16u,
          .leaf_cost = 0.0625,
          .block_cost = 0.25,
          .max_duplication = 4};
}

OctreeOptions instance_octree_options(const SplitSearch* search) {
  return {.search = search,
          .block_size = 1,
          .few_objects = search ? 0u : 8u,
          .leaf_cost = 0.0625,
          .block_cost = 0.125,
          .max_duplication = 8};
}

MeshOctree::MeshOctree(const TriangleMesh& mesh, OctreeKind kind, int threads,
                       const BvhKernels& code)
    : code_(&code) {
  const Time start = monotonic_now();
  const auto search = make_search(kind);
  tree_.bounds = mesh.bounds();
  statistics_.primitives = mesh.triangles.size();
  lay_out(build_octree(triangle_boxes(mesh, threads), mesh_octree_options(search.get()), threads,
                       statistics_),
          mesh, tree_, threads);
  statistics_.bytes = tree_.tree.units.bytes();
  statistics_.build_seconds = to_seconds(monotonic_now() - start);
}

InstanceOctree::InstanceOctree(std::vector<Instance> instances, OctreeKind kind, int threads,
                               const BvhKernels& code)
    : code_(&code) {
  const Time start = monotonic_now();
  const auto search = make_search(kind);
  tree_.instances = std::move(instances);
  statistics_.primitives = tree_.instances.size();
  lay_out(build_octree(instance_boxes(tree_, bounds_), instance_octree_options(search.get()),
                       threads, statistics_),
          tree_, threads);
  statistics_.bytes = bytes_of(tree_);
  statistics_.build_seconds = to_seconds(monotonic_now() - start);
}

}  // namespace tessera
