#include "renderer/accel/deferred_mesh.h"

#include <algorithm>
#include <cmath>

#include "renderer/accel/make_accelerator.h"

namespace tessera {

namespace {

/// Counts while it lives.
struct UnderWay {
  explicit UnderWay(std::atomic<int>& count) : count_(count) { ++count_; }
  ~UnderWay() { --count_; }
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;
  std::atomic<int>& count_;
};

}  // namespace

DeferredMesh::DeferredMesh(std::shared_ptr<const TriangleMesh> mesh, AcceleratorKind kind,
                           int threads, std::shared_ptr<DeferredBuilds> builds,
                           const SharedTree& shared)
    : mesh_(std::move(mesh)),
      kind_(kind),
      threads_(threads),
      shared_(shared),
      builds_(builds ? std::move(builds) : std::make_shared<DeferredBuilds>()),
      bounds_(mesh_->bounds()) {}

/// Sure of it: by a box grown by far more than any rounding. What is not a number does not pass by.
bool DeferredMesh::passes_by(const Ray& ray) const {
  double size = 0;
  for (int a = 0; a < 3; ++a)
    size = std::max(
        {size, std::abs(bounds_.min[a]), std::abs(bounds_.max[a]), std::abs(ray.origin[a])});
  const double margin = size * 0x1p-20;
  double enter = -Bounds3::kInfinity, leave = Bounds3::kInfinity;
  for (int a = 0; a < 3; ++a) {
    const double low = bounds_.min[a] - margin - ray.origin[a];
    const double high = bounds_.max[a] + margin - ray.origin[a];
    if (ray.direction[a] == 0) {
      if (low > 0 || high < 0) return true;
      continue;
    }
    const double t0 = low / ray.direction[a], t1 = high / ray.direction[a];
    if (std::isnan(t0) || std::isnan(t1)) return false;
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter > leave;
}

const Accelerator* DeferredMesh::accelerator_for(const Ray& ray) const {
  if (const Accelerator* built = built_.load(std::memory_order_acquire)) return built;
  if (passes_by(ray)) return nullptr;
  std::call_once(once_, [this] {
    const UnderWay counted(builds_->under_way);
    owned_ = shared_mesh_accelerator(mesh_, kind_, threads_, shared_);
    ++builds_->built;
    built_.store(owned_.get(), std::memory_order_release);
  });
  return owned_.get();
}

bool DeferredMesh::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  const Accelerator* accelerator = accelerator_for(ray);
  return accelerator && accelerator->closest_hit(ray, hit, counters);
}

bool DeferredMesh::any_hit(const Ray& ray, TraversalCounters& counters) const {
  const Accelerator* accelerator = accelerator_for(ray);
  return accelerator && accelerator->any_hit(ray, counters);
}

void DeferredMesh::closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                                TraversalCounters& counters) const {
  const Accelerator* const built = built_.load(std::memory_order_acquire);
  if (built) return built->closest_hits(rays, hits, counters);
  Accelerator::closest_hits(rays, hits, counters);
}

uint64_t DeferredMesh::any_hits(std::span<const Ray> rays, TraversalCounters& counters) const {
  const Accelerator* const built = built_.load(std::memory_order_acquire);
  return built ? built->any_hits(rays, counters) : Accelerator::any_hits(rays, counters);
}

bool DeferredMesh::takes_batches() const {
  return kind_ == AcceleratorKind::bvh || kind_ == AcceleratorKind::bvh_splits;
}

void DeferredMesh::all_hits(const Ray& ray, std::vector<Hit>& hits,
                            TraversalCounters& counters) const {
  if (const Accelerator* accelerator = accelerator_for(ray))
    accelerator->all_hits(ray, hits, counters);
}

AcceleratorStatistics DeferredMesh::statistics() const {
  const Accelerator* built = built_.load(std::memory_order_acquire);
  return built ? built->statistics() : AcceleratorStatistics{};
}

}  // namespace tessera
