#include "renderer/accel/make_accelerator.h"

#include <fmt/format.h>

#include "base/error.h"
#include "renderer/accel/bvh.h"
#include "renderer/accel/embree_mesh.h"
#include "renderer/accel/few_instances.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/octree.h"
#include "renderer/accel/tree_boxes.h"

namespace tessera {
namespace {

// Up to so many a scan in order costs no more than a tree, and nothing to build.
constexpr size_t kFewTriangles = 2;
constexpr size_t kFewScanned = 1;

OctreeKind octree_kind(AcceleratorKind kind) {
  return kind == AcceleratorKind::octree ? OctreeKind::uniform : OctreeKind::nonuniform;
}

}  // namespace

void check_triangle_count(size_t count) {
  if (count <= kMaxPrimitives) return;
  throw scene_error(
      fmt::format("a mesh of {} triangles; expected at most {} in one", count, kMaxPrimitives));
}

const std::vector<std::string>& available_accelerators() {
  static const std::vector<std::string> names{"bvh",    "bvh-splits", "octree", "nonuniform-octree",
                                              "embree", "linear"};
  return names;
}

std::unique_ptr<const Accelerator> make_mesh_accelerator(std::shared_ptr<const TriangleMesh> mesh,
                                                         AcceleratorKind kind, int threads,
                                                         const SharedTree& shared,
                                                         const BvhKernels& code) {
  check_triangle_count(mesh->triangles.size());
  const bool is_small = mesh->triangles.size() <= kFewTriangles;
  if (kind == AcceleratorKind::linear || is_small)
    return std::make_unique<MeshLinearScan>(std::move(mesh));
  if (kind == AcceleratorKind::bvh || kind == AcceleratorKind::bvh_splits) {
    const BvhQuality quality =
        kind == AcceleratorKind::bvh ? BvhQuality::standard : BvhQuality::spatial_splits;
    return std::make_unique<MeshBvh>(shared_mesh_tree(*mesh, threads, quality, shared), code);
  }
  if (kind == AcceleratorKind::embree) {
    if (auto embree = EmbreeMesh::make(std::move(mesh), threads)) return embree;
    throw usage_error(
        "the accelerator 'embree' is not beside this program (tessera_embree.so, built where "
        "Embree 3 "
        "is found); expected bvh, bvh-splits, octree, nonuniform-octree or linear");
  }
  return std::make_unique<MeshOctree>(*mesh, octree_kind(kind), threads, code);
}

std::shared_ptr<const Accelerator> shared_mesh_accelerator(std::shared_ptr<const TriangleMesh> mesh,
                                                           AcceleratorKind kind, int threads,
                                                           const SharedTree& shared,
                                                           const BvhKernels& code) {
  const bool shares =
      shared.live && mesh->triangles.size() >= kTrianglesWorthSharing && &code == &kernels();
  if (auto live = shares ? shared.live->find<Accelerator>(shared.key) : nullptr) return live;
  std::shared_ptr<const Accelerator> built =
      make_mesh_accelerator(std::move(mesh), kind, threads, shared, code);
  if (shares) shared.live->note(shared.key, built);
  return built;
}

std::shared_ptr<const MeshShape> make_mesh_shape(std::shared_ptr<const TriangleMesh> mesh,
                                                 AcceleratorKind kind, int threads,
                                                 const SharedTree& shared, const BvhKernels& code) {
  auto accelerator = shared_mesh_accelerator(mesh, kind, threads, shared, code);
  return std::make_shared<MeshShape>(std::move(mesh), std::move(accelerator));
}

std::shared_ptr<const MeshShape> make_deferred_mesh_shape(std::shared_ptr<const TriangleMesh> mesh,
                                                          AcceleratorKind kind, int threads,
                                                          std::shared_ptr<DeferredBuilds> builds,
                                                          const SharedTree& shared) {
  check_triangle_count(mesh->triangles.size());
  TESSERA_CHECK(kind != AcceleratorKind::embree, "may be absent, which is told before any ray");
  auto accelerator = std::make_unique<DeferredMesh>(mesh, kind, threads, std::move(builds), shared);
  return std::make_shared<MeshShape>(std::move(mesh), std::move(accelerator));
}

std::unique_ptr<const Accelerator> make_instance_accelerator(std::vector<Instance> instances,
                                                             AcceleratorKind kind, int threads,
                                                             const BvhKernels& code) {
  size_t bounded = 0;
  for (const Instance& instance : instances)
    if (const Bounds3 b = bounds_of(instance); can_be_held(instance, b) && !b.empty()) ++bounded;
  const bool is_few = bounded == 0 || (bounded <= kFewScanned);
  const bool has_planes = FewInstances::planes_among(instances) >= PlaneSoA::kLeast;
  if (kind == AcceleratorKind::linear || (is_few && !has_planes))
    return std::make_unique<InstanceLinearScan>(std::move(instances));
  if (bounded <= BoxSoA::kMost) return std::make_unique<FewInstances>(std::move(instances), code);
  if (kind == AcceleratorKind::bvh || kind == AcceleratorKind::bvh_splits ||
      kind == AcceleratorKind::embree)
    return std::make_unique<InstanceBvh>(std::move(instances), threads, code);
  return std::make_unique<InstanceOctree>(std::move(instances), octree_kind(kind), threads, code);
}

}  // namespace tessera
