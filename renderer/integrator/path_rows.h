#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/ray_row.h"
#include "renderer/integrator/integrator.h"
#include "renderer/math/color.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// Follows the paths of several samples bounce by bounce, through scenes whose surfaces scatter
/// evenly: numbers, directions and weights are worked out of as many paths as a vector holds. It is
/// the arithmetic of a path by itself line by line, no product fused with a sum, so that the bits
/// and the counts are the same. Immutable; thread-safe, each thread with its state.
class PathRows {
 public:
  /// Paths at a time.
  static constexpr size_t kMost = RayRow::kMost;

  /// Whether it can: nothing but even scattering, without fog, and something to hit.
  static bool can_follow(const Scene& scene);
  /// Of a scene that it can follow paths through, by the instructions of the set that BvhKernels of
  /// that name are of. `scene` must outlive it.
  explicit PathRows(const Scene& scene, std::string_view instructions = kernels().name);
  /// The radiance along each of 1 to kMost camera rays, which begin and end at the same t, into
  /// `found`; `keys` are those of the samples. Other numbers are refused by a check.
  void radiances(std::span<const Ray> rays, std::span<const SampleKey> keys, std::span<Color> found,
                 TraceState& state) const;

  /// Of one instruction set.
  using Code = void (*)(const Scene&, std::span<const Ray>, std::span<const SampleKey>,
                        std::span<Color>, TraceState&);

 private:
  const Scene& scene_;
  Code code_;
};

}  // namespace tessera
