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

BuiltMeshTree build_mesh_octree(const TriangleMesh& mesh, OctreeKind kind, int threads) {
  BuiltMeshTree built;
  const Time start = monotonic_now();
  const auto search = make_search(kind);
  built.tree.bounds = mesh.bounds();
  built.statistics.primitives = mesh.triangles.size();
  lay_out(build_octree(triangle_boxes(mesh, threads), mesh_octree_options(search.get()), threads,
                       built.statistics),
          mesh, built.tree, threads);
  built.statistics.bytes = built.tree.tree.units.bytes();
  built.statistics.build_seconds = to_seconds(monotonic_now() - start);
  return built;
}

BuiltInstanceTree build_instance_octree(std::vector<Instance> instances, OctreeKind kind,
                                        int threads) {
  BuiltInstanceTree built;
  const Time start = monotonic_now();
  const auto search = make_search(kind);
  built.tree.instances = std::move(instances);
  built.statistics.primitives = built.tree.instances.size();
  lay_out(build_octree(instance_boxes(built.tree, built.bounds),
                       instance_octree_options(search.get()), threads, built.statistics),
          built.tree, threads);
  built.statistics.bytes = bytes_of(built.tree);
  built.statistics.build_seconds = to_seconds(monotonic_now() - start);
  return built;
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
    : MeshTreeAccelerator(build_mesh_octree(mesh, kind, threads), code) {}

InstanceOctree::InstanceOctree(std::vector<Instance> instances, OctreeKind kind, int threads,
                               const BvhKernels& code)
    : InstanceTreeAccelerator(build_instance_octree(std::move(instances), kind, threads), code) {}

}  // namespace tessera
