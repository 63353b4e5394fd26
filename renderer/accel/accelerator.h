#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/accel/ray_batch.h"
#include "renderer/math/bounds.h"
#include "renderer/shapes/ray.h"
#include "renderer/shapes/shape.h"

namespace tessera {

enum class AcceleratorKind { bvh, bvh_splits, octree, nonuniform_octree, embree, linear };

/// By the names of --accel: bvh, bvh-splits, octree, nonuniform-octree, embree, linear.
std::optional<AcceleratorKind> parse_accelerator(std::string_view name);
std::string_view accelerator_name(AcceleratorKind kind);

struct AcceleratorStatistics {
  size_t primitives = 0, nodes = 0, leaves = 0, references = 0, bytes = 0;
  int depth = 0;
  double build_seconds = 0;
};

/// Bounded by the arrays that a leaf or node reference can number; more is refused by a check.
inline constexpr size_t kMaxPrimitives = size_t{1} << 28;

/// Finds hits among many primitives. Every kind returns the same bits, those of a linear scan.
/// Immutable after construction; all calls may run on many threads and none but
/// all_hits() allocates.
class Accelerator {
 public:
  virtual ~Accelerator() = default;
  virtual Bounds3 bounds() const = 0;
  /// As Shape::closest_hit.
  virtual bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const = 0;
  /// As Shape::any_hit.
  virtual bool any_hit(const Ray& ray, TraversalCounters& counters) const = 0;
  /// Appends every hit inside (ray.t_min, ray.t_max), in any order; a hit may be appended twice.
  /// Allocates where `hits` is full.
  virtual void all_hits(const Ray& ray, std::vector<Hit>& hits,
                        TraversalCounters& counters) const = 0;
  /// any_hit(), with the same result, that asks `instance` first, if that is not kNoInstance; sets
  /// it to one that was hit, or to kNoInstance. Only where takes_guesses().
  virtual bool any_hit_by(const Ray& ray, uint32_t& instance, TraversalCounters& counters) const {
    instance = kNoInstance;
    return any_hit(ray, counters);
  }
  virtual bool takes_guesses() const { return false; }
  /// closest_hit for each ray, with the same results; faster where neighbours in the list go much
  /// the same way. As many hits as rays.
  virtual void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                            TraversalCounters& counters) const {
    for (size_t i = 0; i < rays.size(); ++i) closest_hit(rays[i], hits[i], counters);
  }
  /// The same for the rays of a batch, none of them hit so far: a hit each, at an infinite t
  /// where there is none. As many hits as rays.
  virtual void closest_hits(const RayBatch& rays, std::span<Hit> hits,
                            TraversalCounters& counters) const {
    for (size_t i = 0; i < rays.count; ++i) {
      hits[i] = {};
      closest_hit(rays.ray(i), hits[i], counters);
    }
  }
  /// any_hit for at most 64 rays, a bit each.
  virtual uint64_t any_hits(std::span<const Ray> rays, TraversalCounters& counters) const {
    uint64_t hit = 0;
    for (size_t i = 0; i < rays.size(); ++i) hit |= uint64_t{any_hit(rays[i], counters)} << i;
    return hit;
  }
  /// Whether the calls for many rays are faster than a call a ray where they go much the same way.
  virtual bool takes_batches() const { return false; }
  /// any_hit for the rays of a batch, a bit each.
  virtual uint64_t any_hits(const RayBatch& rays, TraversalCounters& counters) const {
    uint64_t hit = 0;
    for (size_t i = 0; i < rays.count; ++i) hit |= uint64_t{any_hit(rays.ray(i), counters)} << i;
    return hit;
  }
  virtual AcceleratorStatistics statistics() const = 0;
};

}  // namespace tessera
