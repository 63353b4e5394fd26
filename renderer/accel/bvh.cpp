#include "renderer/accel/bvh.h"

#include <algorithm>
#include <chrono>

#include "renderer/accel/spatial_splits.h"
#include "renderer/accel/tree_boxes.h"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

AcceleratorStatistics statistics_of(const WideTree& tree, size_t primitives, size_t references) {
  return {.primitives = primitives,
          .nodes = tree.nodes.size(),
          .leaves = tree.leaves,
          .references = references,
          .depth = tree.depth};
}

}  // namespace

MeshBvh::MeshBvh(const TriangleMesh& mesh, int threads, const BvhKernels& code, BvhQuality quality)
    : closest_(code.mesh_closest), any_(code.mesh_any), packet_(code.mesh_packet) {
  const Clock::time_point start = Clock::now();
  std::vector<BuildBox> boxes = triangle_boxes(mesh);
  tree_.bounds = bounds_of(boxes);
  if (quality == BvhQuality::spatial_splits) {
    SpatialSplits splits = split_spatially(mesh, std::move(boxes));
    boxes = std::move(splits.boxes);
    tree_.cut_planes = splits.planes;
  }
  const size_t references = boxes.size();
  const WideTree tree = build_wide_tree(std::move(boxes), 4, threads);
  lay_out(tree, mesh, tree_);
  statistics_ = statistics_of(tree, mesh.triangles.size(), references);
  statistics_.bytes = tree_.tree.units.bytes();
  statistics_.build_seconds = seconds_since(start);
}

void MeshBvh::closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                           TraversalCounters& counters) const {
  for (size_t begin = 0; begin < rays.size(); begin += kPacketSize) {
    const size_t count = std::min(kPacketSize, rays.size() - begin);
    const auto some = rays.subspan(begin, count);
    const auto their_hits = hits.subspan(begin, count);
    if (packet_(tree_, some, their_hits, counters)) continue;
    for (size_t i = 0; i < count; ++i) closest_(tree_, some[i], their_hits[i], counters);
  }
}

InstanceBvh::InstanceBvh(std::vector<Instance> instances, int threads, const BvhKernels& code)
    : closest_(code.instance_closest), any_(code.instance_any) {
  const Clock::time_point start = Clock::now();
  tree_.instances = std::move(instances);
  WideTree tree = build_wide_tree(instance_boxes(tree_, bounds_), 1, threads);
  statistics_ = statistics_of(tree, tree_.instances.size(), tree_.instances.size());
  lay_out(std::move(tree), tree_);
  statistics_.bytes = bytes_of(tree_);
  statistics_.build_seconds = seconds_since(start);
}

}  // namespace tessera
