#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/ray_row.h"
#include "renderer/integrator/integrator.h"
#include "renderer/math/color.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// A ray on its way from mirror to mirror.
struct MirrorPath {
  Ray ray;
  Color sum = kBlack;  ///< of what it met so far
  Color throughput = kWhite;
  double path_length = 0;  ///< metres from the camera to the ray's origin
  uint32_t depth = 0;      ///< mirrors so far
};

/// Follows paths one by one to their ends, for what is rare.
class PathFollower {
 public:
  virtual ~PathFollower() = default;
  virtual Color follow_to_end(MirrorPath path, TraceState& state) const = 0;
};

/// Follows rays through a scene of simple features, several at once: what is worked out of a hit is
/// worked out of as many as a vector holds. It is the arithmetic of a single ray line by line, no
/// product fused with a sum, so that the bits are the same, and the counts but those that
/// integrator.h names. Immutable; thread-safe, each thread with its state.
class RowTracer {
 public:
  /// Rays at a time.
  static constexpr size_t kMost = RayRow::kMost;

  /// Whether it can: lights near and far, without beams and not sorted out by place, and no meshes.
  static bool can_follow(const Scene& scene);
  /// Of a scene that it can follow rays through, by the instructions of the set that BvhKernels of
  /// that name are of. `scene` and `alone` must outlive it.
  RowTracer(const Scene& scene, const PathFollower& alone,
            std::string_view instructions = kernels().name);
  RowTracer(const RowTracer&) = delete;
  RowTracer& operator=(const RowTracer&) = delete;
  /// The radiance along each of 1 to kMost camera rays, which begin and end at the same t, into
  /// `found`, of as many. Another number is refused by a check, as are a first and a last ray that
  /// differ in t.
  void radiances(std::span<const Ray> rays, std::span<Color> found, TraceState& state) const;
  /// The same of a pinhole's rays through raster points.
  void radiances(const Camera::Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
                 std::span<Color> found, TraceState& state) const;

  /// How the surface at a hit of an instance is worked out.
  enum class Form : uint8_t { plane, sphere, other };
  struct Placed {
    Form form = Form::other;
    Vec3 normal;                       ///< of the front; of a plane
    double facing = 1;                 ///< -1 where front and back change places; of a sphere
    std::span<const uint32_t> lights;  ///< that reach it, ascending
  };
  const Scene& scene() const { return scene_; }
  const PathFollower& alone() const { return alone_; }
  const Placed& placed(uint32_t instance) const { return placed_[instance]; }

  /// Of one instruction set.
  struct Code {
    void (*follow_rays)(const RowTracer&, std::span<const Ray>, std::span<Color>, TraceState&);
    void (*follow_rasters)(const RowTracer&, const Camera::Pinhole&,
                           std::span<const Sampler::RasterSample>, std::span<Color>, TraceState&);
  };

 private:
  const Scene& scene_;
  const PathFollower& alone_;
  Code code_;
  std::vector<std::vector<uint32_t>> lights_;  ///< by InstanceShading::light_set
  std::vector<Placed> placed_;                 ///< one an instance
};

}  // namespace tessera
