#include "renderer/accel/bvh.h"

#include "base/monotonic.h"
#include "renderer/accel/tree_boxes.h"

namespace tessera {
namespace {

BuiltInstanceTree build_instance_bvh(std::vector<Instance> instances, int threads) {
  BuiltInstanceTree built;
  const Time start = monotonic_now();
  built.tree.instances = std::move(instances);
  const size_t count = built.tree.instances.size();
  WideTree tree = build_wide_tree(instance_boxes(built.tree, built.bounds), 1, threads);
  built.statistics = statistics_of(tree, count, count);
  lay_out(std::move(tree), built.tree, threads);
  built.statistics.bytes = bytes_of(built.tree);
  built.statistics.build_seconds = to_seconds(monotonic_now() - start);
  return built;
}

}  // namespace

InstanceBvh::InstanceBvh(std::vector<Instance> instances, int threads, const BvhKernels& code)
    : InstanceTreeAccelerator(build_instance_bvh(std::move(instances), threads), code) {}

}  // namespace tessera
