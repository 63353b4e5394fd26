#pragma once

#include <array>
#include <memory>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/embree/embree_module.h"
#include "renderer/accel/linear_scan.h"

namespace tessera {

/// Embree's BVH over boxes of four triangles each, our test inside of them. The boxes are grown by
/// what single precision may lose, and rays that it cannot hold are scanned for: so that every hit
/// is that of the linear scan, bit for bit.
class EmbreeMesh final : public Accelerator {
 public:
  /// Null where the module is absent. At least one triangle, all of them finite.
  static std::unique_ptr<const EmbreeMesh> make(std::shared_ptr<const TriangleMesh> mesh,
                                                int threads);
  Bounds3 bounds() const override { return scan_.bounds(); }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  void all_hits(const Ray& ray, std::vector<Hit>& hits, TraversalCounters& counters) const override;
  AcceleratorStatistics statistics() const override { return statistics_; }

 private:
  explicit EmbreeMesh(std::shared_ptr<const TriangleMesh> mesh) : mesh_(mesh), scan_(mesh) {}

  std::shared_ptr<const TriangleMesh> mesh_;
  MeshLinearScan scan_;
  MeshTree blocks_;  ///< no tree: a leaf of one block for each box
  std::vector<std::array<float, 6>> boxes_;
  float extent_ = 0;
  std::unique_ptr<const EmbreeBoxes> embree_;
  AcceleratorStatistics statistics_;
};

}  // namespace tessera
