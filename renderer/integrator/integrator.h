#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "renderer/math/color.h"
#include "renderer/sampler/sampler.h"
#include "renderer/scene/scene.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/ray.h"

namespace tessera {

/// The most segments that are followed for one camera ray, so that no scene makes a pixel endless.
inline constexpr uint32_t kMaxSegments = 1u << 18;
/// Surfaces that a ray passes unbent on one way.
inline constexpr uint32_t kMaxPasses = 1u << 16;
/// Branches whose whole weight is below this are not followed, so that two pieces of glass do not
/// cost 2^depth rays. Far below what a float pixel resolves.
inline constexpr double kFaintest = 1e-9;

/// Work done, by kind of ray. Totals over pixels do not depend on how the frame is cut, but those
/// of traversal and `occluders_met_again`, which LastOccluders change.
struct TraceCounters {
  TraversalCounters traversal;
  uint64_t rays_primary = 0, rays_shadow = 0, rays_reflection = 0, rays_refraction = 0;
  uint64_t hits = 0;                    ///< of all but shadow rays
  uint64_t occluders_met_again = 0;     ///< shadow rays that end where their light's last one did
  uint64_t shadow_rays_skipped = 0;     ///< lights whose share is zero whatever is in the way
  uint64_t lights_culled = 0;           ///< by their place, before they were asked
  uint64_t branches_skipped = 0;        ///< of a weight that no pixel shows
  uint64_t texture_points_skipped = 0;  ///< hits of textured scenes that no texture is on
  uint64_t numbers_skipped = 0;         ///< pairs of random numbers that nothing read
  uint64_t samples = 0;
  uint64_t samples_skipped = 0;  ///< that would have been the same as another of their pixel
  uint64_t roulette_ends = 0;    ///< paths ended by lot, their share given to others
  uint64_t paths_cut = 0;        ///< what was left out beyond kMaxSegments or kMaxPasses
  uint64_t nan_samples = 0;      ///< results that were no finite colour, counted as black

  void add_to(CounterMap& map) const;
};

/// A stretch of a Whitted path that is still to be followed.
struct PathSegment {
  Ray ray;  ///< its direction is of unit length
  Color throughput = kWhite;
  Media media;               ///< that it begins in
  double path_length = 0;    ///< metres from the camera to its origin
  double view_distance = 0;  ///< metres back to the viewer or the last bend, for fog
  uint32_t depth = 0;        ///< reflections and refractions so far
  uint32_t passes = 0;       ///< surfaces passed unbent so far
};

class BatchTracer;

/// The opaque instance that the last shadow ray to a light ended in: the next ray to it is likely
/// to.
class LastOccluders {
 public:
  LastOccluders() { instances_.fill(kNoInstance); }
  /// Of the scene's light of that number. Where there are more than kLights, some share a place.
  uint32_t& of_light(size_t light) { return instances_[light % kLights]; }

 private:
  static constexpr size_t kLights = 16;
  std::array<uint32_t, kLights> instances_;
};

/// What one thread needs while it traces; made once a tile, so that no ray allocates.
struct TraceState {
  TraceCounters counters;
  LastOccluders last_occluders;
  Camera::PixelCone cone;  ///< of the sample that is being traced
};

/// Radiance along camera rays. Immutable; may be called from many threads, each with its state.
class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Linear radiance that arrives along `ray`, by the sample `key`. `state` belongs to the thread
  /// that calls.
  virtual Color radiance(const Ray& ray, const SampleKey& key, TraceState& state) const = 0;
  /// What finds the radiance along many camera rays faster than radiance() of each, if anything.
  virtual const BatchTracer* batches() const { return nullptr; }
  /// radiance(), to the last bit, of each of `rays` with its key, 1 to RayBatch::kMost camera rays
  /// that begin at the same t. By batches() each has its sample's cone, else that of `state`.
  void radiances(std::span<const Ray> rays, std::span<const SampleKey> keys, std::span<Color> found,
                 TraceState& state) const;
  /// The same of the camera's rays through raster points.
  void radiances(const Camera& camera, std::span<const Sampler::RasterSample> rasters,
                 std::span<const SampleKey> keys, std::span<Color> found, TraceState& state) const;
  /// What radiance() returns, to the last bit, for a camera ray that meets nothing.
  virtual Color background(const Ray& ray) const = 0;
};

/// The integrator that the scene's settings name, in the variant that leaves out what it can.
std::unique_ptr<const Integrator> make_integrator(std::shared_ptr<const Scene> scene);

}  // namespace tessera
