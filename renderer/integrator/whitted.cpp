#include "renderer/integrator/whitted.h"

#include <algorithm>

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/mirror_rows.h"
#include "renderer/integrator/surface_point.h"

namespace tessera {

namespace {

/// kPlain: see SceneFeatures; without kSecondary and kRich alone.
template <bool kShadows, bool kSecondary, bool kRich, bool kPlain = false>
class WhittedIntegrator : public Integrator {
 public:
  explicit WhittedIntegrator(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {
    if (kSecondary) whole_path_.media = media_at_camera(*scene_);
  }

  void make_room(TraceState& state) const override {
    // A level of recursion leaves at most two segments waiting.
    if (kSecondary) state.stack.reserve(2 * size_t{scene_->settings.max_depth} + 3);
  }

  Color radiance(const Ray& ray, const SampleKey& key, TraceState& state) const override {
    ++state.counters.rays_primary;
    const Color sum = follow(ray, whole_path_, key, state);
    return kSecondary ? with_waiting(sum, key, state) : sum;
  }

  Color background(const Ray& ray) const override {
    return scene_->background.radiance(ray.origin, ray.direction, scene_->lights);
  }

 protected:
  const Scene& scene() const { return *scene_; }

  /// `sum` and what comes along the segments that wait on the stack.
  Color with_waiting(Color sum, const SampleKey& key, TraceState& state) const {
    for (uint32_t segments = 1; !state.stack.empty(); ++segments) {
      if (segments >= kMaxSegments) {
        ++state.counters.paths_cut;
        state.stack.clear();
        break;
      }
      const PathSegment segment = state.stack.back();
      state.stack.pop_back();
      sum += follow(segment.ray, segment, key, state);
    }
    return sum;
  }
  /// Not followed, which counts.
  bool is_faint(const Color& throughput, TraceState& state) const {
    if (!(max_component(throughput) < kFaintest) || !scene_->skips.faint_branches) return false;
    ++state.counters.branches_skipped;
    return true;
  }
  /// The way of a ray along `d` from a mirror.
  static Vec3 mirrored(const Vec3& d, const Vec3& n, const SurfacePoint& point) {
    Vec3 r = reflect(d, n);
    // A bent normal may mirror the ray into the surface; there the true one decides.
    if (dot(r, point.geometric_normal) <= 0) r = reflect(d, point.geometric_normal);
    return normalize(r);
  }
  static const Vec3& mirror_normal(const Vec3& d, const SurfacePoint& point) {
    return dot(point.normal, d) < 0 ? point.normal : point.geometric_normal;
  }

 private:
  /// What the segment along `ray` brings by itself; what is to be followed from its end goes on the
  /// stack. segment.ray does not count: a camera ray is not copied.
  Color follow(const Ray& ray, const PathSegment& segment, const SampleKey& key,
               TraceState& state) const {
    Hit hit;
    if (!scene_->surfaces || !scene_->surfaces->closest_hit(ray, hit, state.counters.traversal)) {
      return segment.throughput * background(ray);
    }
    ++state.counters.hits;
    const double path_length = segment.path_length + hit.t;
    SurfacePoint point = surface_point(ray, hit);
    if constexpr (kRich) {
      look_up_textures(*scene_, ray, cone_width(state.cone, path_length), point, state.counters);
    }
    Color throughput = segment.throughput;
    Media media = segment.media;
    Coverage coverage;
    if constexpr (kSecondary) {
      note_media_before(media, point);
      if (!is_black(media.absorption()))
        throughput = throughput * transmittance(media.absorption(), hit.t);
      coverage = straight_coverage(point);
    }
    const bool foggy = !kPlain && scene_->fog.kind != FogKind::none;
    const double clearness = foggy ? scene_->fog.clearness(segment.view_distance + hit.t) : 1.0;
    RayOrigins origins(point.surface);
    Color result = kBlack;
    if (coverage.covered > 0) {
      Color seen = local_radiance<kShadows, kRich, kPlain>(*scene_, point, origins, -ray.direction,
                                                           media, path_length, state);
      if (!kPlain && point.material->grain > 0)
        seen = seen - kWhite * grain(*point.material, segment, key);
      if (foggy) seen = seen * clearness + scene_->fog.color * (1 - clearness);
      result = throughput * seen * coverage.covered;
    }
    if constexpr (kSecondary) {
      if (coverage.through <= 0 && !branches(*point.material)) return result;
      const PathSegment end{.ray = ray,
                            .throughput = throughput,
                            .media = media,
                            .path_length = path_length,
                            .view_distance = segment.view_distance + hit.t,
                            .depth = segment.depth,
                            .passes = segment.passes};
      if (coverage.through > 0) pass_straight(end, point, hit.t, coverage.through, state);
      if (coverage.covered > 0)
        result += branch(end, point, origins, coverage.covered * clearness, state);
    }
    return result;
  }

  SurfacePoint surface_point(const Ray& ray, const Hit& hit) const {
    if constexpr (kPlain) {
      return SurfacePoint(SurfacePoint::Plain{}, *scene_, hit.instance, ray, hit);
    } else {
      return SurfacePoint(*scene_, hit.instance, ray, hit);
    }
  }

  static bool bends(const Material& material) {
    return material.transmission == Transmission::refract && material.transparency > 0;
  }
  static bool branches(const Material& material) { return bends(material) || material.is_mirror(); }

  double grain(const Material& material, const PathSegment& segment, const SampleKey& key) const {
    const auto use = static_cast<SampleUse>(static_cast<uint32_t>(SampleUse::grain) +
                                            segment.depth + segment.passes);
    return material.grain * 0.3 * scene_->sampler->pair(key.x, key.y, key.sample, use).x;
  }

  void pass_straight(const PathSegment& end, const SurfacePoint& point, double t, double through,
                     TraceState& state) const {
    PathSegment next = end;
    next.throughput = end.throughput * through;
    if (is_faint(next.throughput, state)) return;
    if (end.passes >= kMaxPasses) {
      ++state.counters.paths_cut;
      return;
    }
    next.ray = spawn_ray(point.surface, end.ray.direction);
    next.ray.t_max = end.ray.t_max - t;
    pass_into(next.media, point);
    ++next.passes;
    ++state.counters.rays_refraction;
    state.stack.push_back(next);
  }

  /// Mirror and glass. What is pushed last is followed first, so that no more than two segments a
  /// level (what passed straight and what was refracted) wait on the stack.
  Color branch(const PathSegment& end, const SurfacePoint& point, RayOrigins& origins,
               double weight, TraceState& state) const {
    const Material& material = *point.material;
    if (!branches(material)) return kBlack;
    const Vec3 d = end.ray.direction;
    const Vec3& n = mirror_normal(d, point);
    const double cosine = std::min(1.0, -dot(d, n));
    Color share = kRich ? mirrored_share(material, cosine) : material.reflectivity;
    Color result = kBlack;
    if (bends(material)) {
      const bool from_inside = point.is_back && !material.thin;
      const double eta = from_inside ? 1 / material.refractive_index : material.refractive_index;
      double fresnel = fresnel_dielectric(cosine, eta);
      // Both faces of a sheet reflect, and what is between them does so again and again.
      if (material.thin) fresnel = 2 * fresnel / (1 + fresnel);
      share += kWhite * (material.transparency * fresnel);
      Vec3 beyond = d;
      if (fresnel < 1 && (material.thin || refract(d, n, eta, beyond))) {
        const double through = weight * material.transparency * (1 - fresnel);
        const Color tint = kRich ? transmission_tint(material) : kWhite;
        result += bend(end, origins, beyond, tint * through, media_beyond(end.media, point),
                       state.counters.rays_refraction, state);
      }
    }
    return result + bend(end, origins, mirrored(d, n, point), share * weight, end.media,
                         state.counters.rays_reflection, state);
  }

  Color bend(const PathSegment& end, RayOrigins& origins, const Vec3& direction, const Color& share,
             const Media& media, uint64_t& counter, TraceState& state) const {
    PathSegment next{.ray = origins.spawn(direction),
                     .throughput = end.throughput * share,
                     .media = media,
                     .path_length = end.path_length,
                     .depth = end.depth + 1,
                     .passes = end.passes};
    if (is_faint(next.throughput, state)) return kBlack;
    if (end.depth >= scene_->settings.max_depth) {
      return scene_->settings.background_at_max_depth ? next.throughput * background(next.ray)
                                                      : kBlack;
    }
    ++counter;
    state.stack.push_back(next);
    return kBlack;
  }

  std::shared_ptr<const Scene> scene_;
  PathSegment whole_path_;  ///< what all camera rays begin with
};

/// Of scenes of simple features, plain ones in rows too: a ray goes on from a mirror as one ray, so
/// that none waits.
template <bool kShadows>
class MirrorIntegrator final : public WhittedIntegrator<kShadows, true, false>,
                               public MirrorPathFollower {
 public:
  using Base = WhittedIntegrator<kShadows, true, false>;
  explicit MirrorIntegrator(std::shared_ptr<const Scene> scene) : Base(std::move(scene)) {
    if (can_follow_mirrors(this->scene())) rows_ = make_mirror_rows(this->scene(), *this);
  }

  Color radiance(const Ray& ray, const SampleKey&, TraceState& state) const override {
    ++state.counters.rays_primary;
    return follow_to_end({.ray = ray}, state);
  }
  const RowTracer* rows() const override { return rows_.get(); }

 private:
  Color follow_to_end(MirrorPath path, TraceState& state) const override {
    const Scene& scene = this->scene();
    auto& [ray, sum, throughput, path_length, depth] = path;
    for (;; ++depth) {
      Hit hit;
      if (!scene.surfaces || !scene.surfaces->closest_hit(ray, hit, state.counters.traversal)) {
        return sum + throughput * this->background(ray);
      }
      const SurfacePoint point(SurfacePoint::Plain{}, scene, hit.instance, ray, hit);
      const Material& material = *point.material;
      if (point.is_back && material.sides == Sides::front_only) [[unlikely]] {
        // By the last digit alone, for such surfaces are not met from behind.
        state.stack.push_back({.ray = ray,
                               .throughput = throughput,
                               .media = {},
                               .path_length = path_length,
                               .depth = depth});
        return this->with_waiting(sum, {}, state);
      }
      ++state.counters.hits;
      path_length += hit.t;
      RayOrigins origins(point.surface);
      Color result =
          throughput * local_radiance<kShadows, false, true, false>(
                           scene, point, origins, -ray.direction, {}, path_length, state);
      if (!material.is_mirror()) return sum + result;
      const Vec3 direction =
          this->mirrored(ray.direction, this->mirror_normal(ray.direction, point), point);
      throughput = throughput * material.reflectivity;
      if (this->is_faint(throughput, state)) return sum + result;
      ray = origins.spawn(direction);
      if (depth >= scene.settings.max_depth) {
        if (scene.settings.background_at_max_depth) result += throughput * this->background(ray);
        return sum + result;
      }
      ++state.counters.rays_reflection;
      sum += result;
    }
  }

  std::unique_ptr<const RowTracer> rows_;
};

template <bool kShadows, bool kSecondary>
std::unique_ptr<const Integrator> make_variant(std::shared_ptr<const Scene> scene) {
  if (scene->features.rich) {
    return std::make_unique<WhittedIntegrator<kShadows, kSecondary, true>>(std::move(scene));
  }
  return std::make_unique<WhittedIntegrator<kShadows, kSecondary, false>>(std::move(scene));
}

}  // namespace

std::unique_ptr<const Integrator> make_whitted(std::shared_ptr<const Scene> scene) {
  const SceneFeatures features = scene->features;
  const bool in_rows = can_follow_mirrors(*scene);
  if (features.plain && !in_rows && features.shadows) {
    return std::make_unique<WhittedIntegrator<true, false, false, true>>(std::move(scene));
  }
  if (features.plain && !in_rows) {
    return std::make_unique<WhittedIntegrator<false, false, false, true>>(std::move(scene));
  }
  if (features.simple && features.shadows) {
    return std::make_unique<MirrorIntegrator<true>>(std::move(scene));
  }
  if (features.simple) return std::make_unique<MirrorIntegrator<false>>(std::move(scene));
  if (features.shadows && features.secondary) return make_variant<true, true>(std::move(scene));
  if (features.shadows) return make_variant<true, false>(std::move(scene));
  if (features.secondary) return make_variant<false, true>(std::move(scene));
  return make_variant<false, false>(std::move(scene));
}

}  // namespace tessera
