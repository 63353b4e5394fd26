#include "renderer/accel/bvh.h"

#include <algorithm>

#include "base/monotonic.h"
#include "base/uninitialized.h"
#include "renderer/accel/tree_boxes.h"

namespace tessera {
namespace {

/// Traces kPacketSize rays at a time by packet(rays, index of the first), and by single(index)
/// those that it returns false for, with nothing done.
template <typename Packet, typename Single>
void trace_in_packets(std::span<const Ray> rays, const Packet& packet, const Single& single) {
  for (size_t begin = 0; begin < rays.size(); begin += kPacketSize) {
    const size_t count = std::min(kPacketSize, rays.size() - begin);
    if (packet(rays.subspan(begin, count), begin)) continue;
    for (size_t i = begin; i < begin + count; ++i) single(i);
  }
}

}  // namespace

MeshBvh::MeshBvh(BuiltMeshTree built, const BvhKernels& code)
    : tree_(std::move(built.tree)),
      closest_(code.mesh_closest),
      any_(code.mesh_any),
      all_(code.mesh_all),
      closest_packet_(code.mesh_closest_packet),
      any_packet_(code.mesh_any_packet),
      statistics_(built.statistics) {}

void MeshBvh::closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                           TraversalCounters& counters) const {
  trace_in_packets(
      rays,
      [&](std::span<const Ray> some, size_t begin) {
        return closest_packet_(tree_, some, hits.subspan(begin, some.size()), counters);
      },
      [&](size_t i) { closest_(tree_, rays[i], hits[i], counters); });
}

uint64_t MeshBvh::any_hits(std::span<const Ray> rays, TraversalCounters& counters) const {
  uint64_t hit = 0;
  trace_in_packets(
      rays,
      [&](std::span<const Ray> some, size_t begin) {
        uint32_t bits = 0;
        const bool is_traced = any_packet_(tree_, some, bits, counters);
        hit |= uint64_t{bits} << begin;
        return is_traced;
      },
      [&](size_t i) { hit |= uint64_t{any_(tree_, rays[i], counters)} << i; });
  return hit;
}

InstanceBvh::InstanceBvh(std::vector<Instance> instances, int threads, const BvhKernels& code)
    : takes_batches_(any_takes_batches(instances)),
      closest_(code.instance_closest),
      any_(code.instance_any),
      all_(code.instance_all),
      closest_packet_(code.instance_closest_packet),
      any_packet_(code.instance_any_packet) {
  const Time start = monotonic_now();
  tree_.instances = std::move(instances);
  WideTree tree = build_wide_tree(instance_boxes(tree_, bounds_), 1, threads);
  statistics_ = statistics_of(tree, tree_.instances.size(), tree_.instances.size());
  lay_out(std::move(tree), tree_, threads);
  statistics_.bytes = bytes_of(tree_);
  statistics_.build_seconds = to_seconds(monotonic_now() - start);
}

void InstanceBvh::closest_hits(const RayBatch& rays, std::span<Hit> hits,
                               TraversalCounters& counters) const {
  if (!takes_batch(rays)) return Accelerator::closest_hits(rays, hits, counters);
  Uninitialized<Ray, RayBatch::kMost> room;
  const std::span<const Ray> all = rays_of(rays, room);
  std::ranges::fill(hits, Hit{});
  trace_in_packets(
      all,
      [&](std::span<const Ray> some, size_t begin) {
        return closest_packet_(tree_, some, hits.subspan(begin, some.size()), counters);
      },
      [&](size_t i) { closest_(tree_, all[i], hits[i], counters); });
}

uint64_t InstanceBvh::any_hits(const RayBatch& rays, TraversalCounters& counters) const {
  if (!takes_batch(rays)) return Accelerator::any_hits(rays, counters);
  Uninitialized<Ray, RayBatch::kMost> room;
  const std::span<const Ray> all = rays_of(rays, room);
  uint64_t hit = 0;
  trace_in_packets(
      all,
      [&](std::span<const Ray> some, size_t begin) {
        uint32_t bits = 0;
        const bool is_traced = any_packet_(tree_, some, bits, counters);
        hit |= uint64_t{bits} << begin;
        return is_traced;
      },
      [&](size_t i) { hit |= uint64_t{any_hit(all[i], counters)} << i; });
  return hit;
}

}  // namespace tessera
