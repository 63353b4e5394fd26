// Compiled once for each instruction set: what all that follows batches of camera rays has in
// common.
#if defined(TESSERA_WAVEFRONT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_WAVEFRONT_INL_H
#undef TESSERA_WAVEFRONT_INL_H
#else
#define TESSERA_WAVEFRONT_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "base/uninitialized.h"
#include "renderer/integrator/batch_tracer.h"
#include "renderer/integrator/lane_batch-inl.h"
#include "renderer/integrator/lane_camera-inl.h"
#include "renderer/integrator/light_lanes-inl.h"
#include "renderer/scene/scene.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Rays that have met as many surfaces.
struct WavefrontRays {
  RayBatch rays;
  alignas(64) double throughput[3][RayBatch::kPadded];
  alignas(64) double path_length[RayBatch::kPadded];  ///< metres from the camera to the origin
  uint32_t number[RayBatch::kMost];                   ///< of the camera ray
};

/// Follows a batch of camera rays from front to front. `Front` is a WavefrontRays, with more where
/// rays carry more. Used once.
template <typename Front>
class Wavefront {
 public:
  /// To be set before they are followed.
  RayBatch& camera_rays() { return now_->rays; }

 protected:
  Wavefront(const Scene& scene, std::span<Color> found, TraceState& state)
      : scene_(scene), found_(found), state_(state) {}

  /// `step` works out what now_ meets, and fills next_.
  template <typename Step>
  void follow_all(const Step& step) {
    const size_t count = now_->rays.count;
    for (auto& channel : now_->throughput) std::fill_n(channel, count, 1.0);
    std::fill_n(now_->path_length, count, 0.0);
    std::iota(now_->number, now_->number + count, 0u);
    std::ranges::fill(found_, kBlack);
    state_.counters.rays_primary += count;
    for (; now_->rays.count > 0; ++vertex_) {
      next_->rays.begin();
      step();
      std::swap(now_, next_);
    }
  }

  /// Of the camera rays, where something is rich.
  void find_cones(std::span<const SampleKey> keys) {
    if (!scene_.features.rich) return;
    const uint32_t rays = std::max(scene_.camera->lens_samples(), 1u);
    for (size_t i = 0; i < keys.size(); ++i) cones_[i] = scene_.cones.of(keys[i].sample / rays);
  }

  void find_hits() {
    if (!scene_.surfaces) {
      std::fill_n(hits_.data(), now_->rays.count, Hit{});
      return;
    }
    scene_.surfaces->closest_hits(now_->rays, {hits_.data(), now_->rays.count},
                                  state_.counters.traversal);
  }
  bool is_hit(uint32_t place) const {
    return hits_[place].t < std::numeric_limits<double>::infinity();
  }
  /// Takes from the `n` places `left`, all of hits, those of one instance to `same`, whose last
  /// vector is filled up by the first of them; how many they are. All keep their order.
  size_t take_instance(uint32_t* left, size_t& n, uint32_t* same) const {
    const uint32_t instance = hits_[left[0]].instance;
    size_t of_it = 0, others = 0;
    for (size_t i = 0; i < n; ++i) {
      const uint32_t place = left[i];
      const bool is_it = hits_[place].instance == instance;
      same[of_it] = left[others] = place;
      of_it += is_it;
      others += !is_it;
    }
    n = others;
    std::fill_n(same + of_it, kLanes, same[0]);
    return of_it;
  }

  /// What its camera ray has found so far.
  Color& sum_of(uint32_t place) { return found_[now_->number[place]]; }
  Color throughput(uint32_t place) const { return color_at(now_->throughput, place); }
  Color background(const Ray& ray) const {
    return scene_.background.radiance(ray.origin, ray.direction, scene_.lights);
  }
  /// Calls act(place, seen, &place_in_panorama() or null) for each of the places, whose
  /// rays meet nothing; there is room for a vector behind them.
  template <typename Act>
  void look_beyond(uint32_t* places, size_t count, const Act& act) const {
    const Background& beyond = scene_.background;
    if (!beyond.is_plain_panorama()) {
      for (size_t i = 0; i < count; ++i)
        act(places[i], background(now_->rays.ray(places[i])), nullptr);
      return;
    }
    std::fill_n(places + count, kLanes, places[0]);
    alignas(64) double s[RayBatch::kPadded], t[RayBatch::kPadded];
    for (size_t i = 0; i < count; i += kLanes) {
      const LaneIndices at = indices_of(places + i);
      const Lanes2 place = place_in_panorama(beyond, gather(now_->rays.direction, at));
      hn::Store(place.x, kLaneTag, s + i);
      hn::Store(place.y, kLaneTag, t + i);
      // A large picture is in no cache; by the time that it is looked at, it is.
      for (size_t lane = 0; lane < kLanes; ++lane)
        beyond.picture->prefetch(s[i + lane], t[i + lane]);
    }
    for (size_t i = 0; i < count; ++i) {
      const Vec2 at{s[i], t[i]};
      act(places[i], beyond.panorama_at(at.x, at.y), &at);
    }
  }

  const Scene& scene_;
  std::span<Color> found_;
  TraceState& state_;
  Front fronts_[2];
  Front *now_ = &fronts_[0], *next_ = &fronts_[1];
  Uninitialized<Hit, RayBatch::kMost> hits_;                 ///< of now_
  uint32_t vertex_ = 0;                                      ///< steps before this one
  Uninitialized<Camera::PixelCone, RayBatch::kMost> cones_;  ///< by find_cones()
};

/// The batches that `Follower` follows, by what it wants to know of the scene's surfaces.
template <typename Follower>
class BatchTracerOf final : public BatchTracer {
 public:
  template <typename... Given>
  explicit BatchTracerOf(const Given&... given) : surfaces_(given...) {}

 private:
  void follow(std::span<const Ray> rays, std::span<const SampleKey> keys, std::span<Color> found,
              TraceState& state) const override {
    Follower follower(surfaces_, found, state);
    set_rays(rays, follower.camera_rays());
    follower.follow(keys);
  }
  /// Camera::ray() through each.
  void follow(const Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
              std::span<const SampleKey> keys, std::span<Color> found,
              TraceState& state) const override {
    Follower follower(surfaces_, found, state);
    set_rays(camera, rasters, follower.camera_rays());
    follower.follow(keys);
  }

  typename Follower::Surfaces surfaces_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
