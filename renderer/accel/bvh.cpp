#include "renderer/accel/bvh.h"

#include <algorithm>

#include "base/monotonic.h"
#include "renderer/accel/tree_boxes.h"

namespace tessera {
MeshBvh::MeshBvh(BuiltMeshTree built, const BvhKernels& code)
    : tree_(std::move(built.tree)),
      closest_(code.mesh_closest),
      any_(code.mesh_any),
      all_(code.mesh_all),
      packet_(code.mesh_packet),
      statistics_(built.statistics) {}

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
    : closest_(code.instance_closest), any_(code.instance_any), all_(code.instance_all) {
  const Time start = monotonic_now();
  tree_.instances = std::move(instances);
  WideTree tree = build_wide_tree(instance_boxes(tree_, bounds_), 1, threads);
  statistics_ = statistics_of(tree, tree_.instances.size(), tree_.instances.size());
  lay_out(std::move(tree), tree_, threads);
  statistics_.bytes = bytes_of(tree_);
  statistics_.build_seconds = to_seconds(monotonic_now() - start);
}

}  // namespace tessera
