#include "renderer/integrator/whitted.h"

#include <algorithm>

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/integrator/whitted_batches.h"
#include "renderer/shading/bent_normal.h"

namespace tessera {

namespace {

/// `kRich`: the scene has rich materials.
template <bool kRich>
class WhittedIntegrator final : public Integrator, public SegmentTracer {
 public:
  explicit WhittedIntegrator(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {
    whole_path_.media = media_at_camera(*scene_);
    if (can_batch_whitted(*scene_)) batches_ = make_whitted_batches(*scene_, *this);
  }

  void make_room(TraceState& state) const override {
    // A level of recursion leaves at most two segments waiting.
    if (scene_->features.secondary) state.stack.reserve(2 * size_t{scene_->settings.max_depth} + 3);
  }

  Color radiance(const Ray& ray, const SampleKey& key, TraceState& state) const override {
    ++state.counters.rays_primary;
    return with_waiting(follow(ray, whole_path_, key, state), key, state);
  }

  Color background(const Ray& ray) const override {
    return scene_->background.radiance(ray.origin, ray.direction, scene_->lights);
  }
  const BatchTracer* batches() const override { return batches_.get(); }

 private:
  Color trace_to_end(const Color& sum, const PathSegment& segment,
                     TraceState& state) const override {
    state.stack.push_back(segment);
    return with_waiting(sum, {}, state);
  }

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
    if (!(max_component(throughput) < kFaintest)) return false;
    ++state.counters.branches_skipped;
    return true;
  }

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
    SurfacePoint point(*scene_, hit.instance, ray, hit);
    if constexpr (kRich) {
      look_up_textures(*scene_, ray, cone_width(state.cone, path_length), point, state.counters);
    }
    Media media = segment.media;
    note_media_before(media, point);
    Color throughput = segment.throughput;
    if (!is_black(media.absorption()))
      throughput = throughput * transmittance(media.absorption(), hit.t);
    const Coverage coverage = straight_coverage(point);
    const bool is_foggy = scene_->fog.kind != FogKind::none;
    const double clearness = is_foggy ? scene_->fog.clearness(segment.view_distance + hit.t) : 1.0;
    RayOrigins origins(point.surface);
    Color result = kBlack;
    if (coverage.covered > 0) {
      Color seen =
          local_radiance<kRich>(*scene_, point, origins, -ray.direction, media, path_length, state);
      if (point.material->grain > 0) seen = seen - kWhite * grain(*point.material, segment, key);
      if (is_foggy) seen = seen * clearness + scene_->fog.color * (1 - clearness);
      result = throughput * seen * coverage.covered;
    }
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
    return result;
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
    const Vec3& facet = point.geometric_normal;
    const Vec3 n = bent_normal(point.normal, facet, -d);
    const double cosine = std::clamp(-dot(d, n), 0.0, 1.0);
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
        beyond = kept_on_side(beyond, facet, true);
        result += bend(end, origins, beyond, tint * through, media_beyond(end.media, point),
                       state.counters.rays_refraction, state);
      }
    }
    const Vec3 back = mirrored_view(n, facet, -d);
    return result + bend(end, origins, back, share * weight, end.media,
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
  std::unique_ptr<const BatchTracer> batches_;
};

}  // namespace

std::unique_ptr<const Integrator> make_whitted(std::shared_ptr<const Scene> scene) {
  if (scene->features.rich) return std::make_unique<WhittedIntegrator<true>>(std::move(scene));
  return std::make_unique<WhittedIntegrator<false>>(std::move(scene));
}

}  // namespace tessera
