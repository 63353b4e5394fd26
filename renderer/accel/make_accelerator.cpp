#include "renderer/accel/make_accelerator.h"

#include <fmt/format.h>

#include "base/error.h"
#include "renderer/accel/linear_scan.h"

namespace tessera {
namespace {

void require_known(AcceleratorKind kind) {
  if (kind == AcceleratorKind::bvh || kind == AcceleratorKind::linear) return;
  throw usage_error(
      fmt::format("the accelerator '{}' is not in this program; expected bvh or linear",
                  accelerator_name(kind)));
}

}  // namespace

std::unique_ptr<const Accelerator> make_mesh_accelerator(std::shared_ptr<const TriangleMesh> mesh,
                                                         AcceleratorKind kind, int) {
  require_known(kind);
  TESSERA_CHECK(mesh->triangles.size() <= kMaxPrimitives,
                fmt::format("{} > {}", mesh->triangles.size(), kMaxPrimitives));
  return std::make_unique<MeshLinearScan>(std::move(mesh));
}

std::shared_ptr<const MeshShape> make_mesh_shape(std::shared_ptr<const TriangleMesh> mesh,
                                                 AcceleratorKind kind, int threads) {
  auto accelerator = make_mesh_accelerator(mesh, kind, threads);
  return std::make_shared<MeshShape>(std::move(mesh), std::move(accelerator));
}

std::unique_ptr<const Accelerator> make_instance_accelerator(std::vector<Instance> instances,
                                                             AcceleratorKind kind, int) {
  require_known(kind);
  return std::make_unique<InstanceLinearScan>(std::move(instances));
}

}  // namespace tessera
