#pragma once

#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/octree_builder.h"

namespace tessera {

enum class OctreeKind {
  uniform,           ///< voxels split at their centre
  nonuniform,        ///< where SweepSearch finds the study's function least
  nonuniform_nlopt,  ///< where NLopt does; throws a usage Error where its module is not installed
};

/// What the accelerators below build with; `search` must outlive the build.
OctreeOptions mesh_octree_options(const SplitSearch* search);
OctreeOptions instance_octree_options(const SplitSearch* search);

/// Octree over the triangles of a mesh: see build_octree(). It keeps its own copy of the vertices
/// and does not need the mesh afterwards.
class MeshOctree final : public Accelerator {
 public:
  /// At least one triangle, all of them finite.
  MeshOctree(const TriangleMesh& mesh, OctreeKind kind, int threads,
             const BvhKernels& code = kernels());
  Bounds3 bounds() const override { return tree_.bounds; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return code_->mesh_closest(tree_, ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    return code_->mesh_any(tree_, ray, counters);
  }
  void all_hits(const Ray& ray, std::vector<Hit>& hits,
                TraversalCounters& counters) const override {
    code_->mesh_all(tree_, ray, hits, counters);
  }
  AcceleratorStatistics statistics() const override { return statistics_; }
  const MeshTree& tree() const { return tree_; }

 private:
  MeshTree tree_;
  const BvhKernels* code_;
  AcceleratorStatistics statistics_;
};

/// The same over instances. What cannot be held is kept outside of the tree and always tested.
class InstanceOctree final : public Accelerator {
 public:
  /// At least one instance that can_be_held().
  InstanceOctree(std::vector<Instance> instances, OctreeKind kind, int threads,
                 const BvhKernels& code = kernels());
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return code_->instance_closest(tree_, ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    uint32_t first = kNoInstance;
    return code_->instance_any(tree_, ray, first, counters);
  }
  bool any_hit_by(const Ray& ray, uint32_t& instance, TraversalCounters& counters) const override {
    return code_->instance_any(tree_, ray, instance, counters);
  }
  bool takes_guesses() const override { return true; }
  void all_hits(const Ray& ray, std::vector<Hit>& hits,
                TraversalCounters& counters) const override {
    code_->instance_all(tree_, ray, hits, counters);
  }
  AcceleratorStatistics statistics() const override { return statistics_; }
  const InstanceTree& tree() const { return tree_; }

 private:
  InstanceTree tree_;
  Bounds3 bounds_;
  const BvhKernels* code_;
  AcceleratorStatistics statistics_;
};

}  // namespace tessera
