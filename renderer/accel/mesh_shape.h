#pragma once

#include <memory>

#include "renderer/accel/accelerator.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// A triangle mesh with the accelerator that finds its hits. Primitives are triangles.
class MeshShape final : public Shape {
 public:
  /// `accelerator` must be over `mesh`.
  MeshShape(std::shared_ptr<const TriangleMesh> mesh,
            std::shared_ptr<const Accelerator> accelerator)
      : mesh_(std::move(mesh)), accelerator_(std::move(accelerator)) {}

  Bounds3 bounds() const override { return accelerator_->bounds(); }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    return accelerator_->closest_hit(ray, hit, counters);
  }
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override {
    return accelerator_->any_hit(ray, counters);
  }
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                    TraversalCounters& counters) const override {
    accelerator_->closest_hits(rays, hits, counters);
  }
  uint64_t any_hits(std::span<const Ray> rays, TraversalCounters& counters) const override {
    return accelerator_->any_hits(rays, counters);
  }
  bool takes_batches() const override { return accelerator_->takes_batches(); }
  void all_hits(const Ray& ray, std::vector<Hit>& hits,
                TraversalCounters& counters) const override {
    accelerator_->all_hits(ray, hits, counters);
  }
  int crossing_number(const Ray& ray, std::span<const Hit> hits) const override {
    return mesh_crossing_number(*mesh_, ray, hits);
  }
  LocalSurface surface(const Ray&, const Hit& hit) const override {
    return triangle_surface(*mesh_, hit.primitive, hit.u, hit.v);
  }
  size_t primitive_count() const override { return mesh_->triangles.size(); }

  const TriangleMesh& mesh() const { return *mesh_; }
  const Accelerator& accelerator() const { return *accelerator_; }

 private:
  std::shared_ptr<const TriangleMesh> mesh_;
  std::shared_ptr<const Accelerator> accelerator_;
};

}  // namespace tessera
