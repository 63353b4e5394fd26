#include "renderer/accel/tree_accelerator.h"

#include <algorithm>

#include "base/uninitialized.h"

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

MeshTreeAccelerator::MeshTreeAccelerator(BuiltMeshTree built, const BvhKernels& code)
    : tree_(std::move(built.tree)), code_(code), statistics_(built.statistics) {}

void MeshTreeAccelerator::closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                                       TraversalCounters& counters) const {
  trace_in_packets(
      rays,
      [&](std::span<const Ray> some, size_t begin) {
        return code_.mesh_closest_packet(tree_, some, hits.subspan(begin, some.size()), counters);
      },
      [&](size_t i) { code_.mesh_closest(tree_, rays[i], hits[i], counters); });
}

uint64_t MeshTreeAccelerator::any_hits(std::span<const Ray> rays,
                                       TraversalCounters& counters) const {
  uint64_t hit = 0;
  trace_in_packets(
      rays,
      [&](std::span<const Ray> some, size_t begin) {
        uint32_t bits = 0;
        const bool is_traced = code_.mesh_any_packet(tree_, some, bits, counters);
        hit |= uint64_t{bits} << begin;
        return is_traced;
      },
      [&](size_t i) { hit |= uint64_t{code_.mesh_any(tree_, rays[i], counters)} << i; });
  return hit;
}

InstanceTreeAccelerator::InstanceTreeAccelerator(BuiltInstanceTree built, const BvhKernels& code)
    : tree_(std::move(built.tree)),
      takes_batches_(any_takes_batches(tree_.instances)),
      bounds_(built.bounds),
      code_(code),
      statistics_(built.statistics) {}

void InstanceTreeAccelerator::closest_hits(const RayBatch& rays, std::span<Hit> hits,
                                           TraversalCounters& counters) const {
  if (!takes_batch(rays)) return Accelerator::closest_hits(rays, hits, counters);
  Uninitialized<Ray, RayBatch::kMost> room;
  const std::span<const Ray> all = rays_of(rays, room);
  std::ranges::fill(hits, Hit{});
  trace_in_packets(
      all,
      [&](std::span<const Ray> some, size_t begin) {
        return code_.instance_closest_packet(tree_, some, hits.subspan(begin, some.size()),
                                             counters);
      },
      [&](size_t i) { code_.instance_closest(tree_, all[i], hits[i], counters); });
}

uint64_t InstanceTreeAccelerator::any_hits(const RayBatch& rays,
                                           TraversalCounters& counters) const {
  if (!takes_batch(rays)) return Accelerator::any_hits(rays, counters);
  Uninitialized<Ray, RayBatch::kMost> room;
  const std::span<const Ray> all = rays_of(rays, room);
  uint64_t hit = 0;
  trace_in_packets(
      all,
      [&](std::span<const Ray> some, size_t begin) {
        uint32_t bits = 0;
        const bool is_traced = code_.instance_any_packet(tree_, some, bits, counters);
        hit |= uint64_t{bits} << begin;
        return is_traced;
      },
      [&](size_t i) { hit |= uint64_t{any_hit(all[i], counters)} << i; });
  return hit;
}

}  // namespace tessera
