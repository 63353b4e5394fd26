#include "renderer/integrator/whitted_hit.h"

#include <algorithm>

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/shading/clamped_normal.h"

namespace tessera {

namespace {

/// Of one hit. `kRich`: the scene has rich materials.
template <bool kRich>
class WhittedHit {
 public:
  WhittedHit(const Scene& scene, const PathSegment& segment, Branches& branches, TraceState& state)
      : scene_(scene), segment_(segment), branches_(branches), state_(state) {}

  Color look(const Hit& hit, const SampleKey& key) {
    ++state_.counters.hits;
    const Ray& ray = segment_.ray;
    const double path_length = segment_.path_length + hit.t;
    SurfacePoint point(scene_, hit.instance, ray, hit);
    if constexpr (kRich) {
      look_up_textures(scene_, ray, cone_width(state_.cone, path_length), point, state_.counters);
    }
    Media media = segment_.media;
    note_media_before(media, point);
    Color throughput = segment_.throughput;
    if (!is_black(media.absorption()))
      throughput = throughput * transmittance(media.absorption(), hit.t);
    const Coverage coverage = straight_coverage(point);
    const bool is_foggy = scene_.fog.kind != FogKind::none;
    const double clearness = is_foggy ? scene_.fog.clearness(segment_.view_distance + hit.t) : 1.0;
    RayOrigins origins(point.surface);
    Color result = kBlack;
    if (coverage.covered > 0) {
      Color seen =
          local_radiance<kRich>(scene_, point, origins, -ray.direction, media, path_length, state_);
      if (point.material->grain > 0) seen = seen - kWhite * grain(*point.material, key);
      if (is_foggy) seen = seen * clearness + scene_.fog.color * (1 - clearness);
      result = throughput * seen * coverage.covered;
    }
    if (coverage.through <= 0 && !sends_on(*point.material)) return result;
    const PathSegment end{.ray = ray,
                          .throughput = throughput,
                          .media = media,
                          .path_length = path_length,
                          .view_distance = segment_.view_distance + hit.t,
                          .depth = segment_.depth,
                          .passes = segment_.passes};
    if (coverage.through > 0) pass_straight(end, point, hit.t, coverage.through);
    if (coverage.covered > 0) result += branch(end, point, origins, coverage.covered * clearness);
    return result;
  }

 private:
  /// Not followed, which counts.
  bool is_faint(const Color& throughput) {
    if (!(max_component(throughput) < kFaintest)) return false;
    ++state_.counters.branches_skipped;
    return true;
  }
  static bool bends(const Material& material) { return material.refracted() > 0; }
  static bool sends_on(const Material& material) { return bends(material) || material.is_mirror(); }

  double grain(const Material& material, const SampleKey& key) const {
    const auto use = static_cast<SampleUse>(static_cast<uint32_t>(SampleUse::grain) +
                                            segment_.depth + segment_.passes);
    return material.grain * 0.3 * scene_.sampler->pair(key.x, key.y, key.sample, use).x;
  }

  void pass_straight(const PathSegment& end, const SurfacePoint& point, double t, double through) {
    PathSegment next = end;
    next.throughput = end.throughput * through;
    if (is_faint(next.throughput)) return;
    if (end.passes >= kMaxPasses) {
      ++state_.counters.paths_cut;
      return;
    }
    next.ray = spawn_ray(point.surface, end.ray.direction);
    next.ray.t_max = end.ray.t_max - t;
    pass_into(next.media, point);
    ++next.passes;
    ++state_.counters.rays_refraction;
    branches_.add(next);
  }

  /// Mirror and glass.
  Color branch(const PathSegment& end, const SurfacePoint& point, RayOrigins& origins,
               double weight) {
    const Material& material = *point.material;
    if (!sends_on(material)) return kBlack;
    const Vec3 d = end.ray.direction;
    const Vec3& facet = point.geometric_normal;
    const Vec3 n = clamped_normal(point.normal, facet, -d);
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
        beyond = reflected_to_side(beyond, facet, true);
        result += bend(end, origins, beyond, tint * through, media_beyond(end.media, point),
                       state_.counters.rays_refraction);
      }
    }
    const Vec3 back = mirror_direction(n, facet, -d);
    return result +
           bend(end, origins, back, share * weight, end.media, state_.counters.rays_reflection);
  }

  Color bend(const PathSegment& end, RayOrigins& origins, const Vec3& direction, const Color& share,
             const Media& media, uint64_t& counter) {
    PathSegment next{.ray = origins.spawn(direction),
                     .throughput = end.throughput * share,
                     .media = media,
                     .path_length = end.path_length,
                     .depth = end.depth + 1,
                     .passes = end.passes};
    if (is_faint(next.throughput)) return kBlack;
    if (end.depth >= scene_.settings.max_depth) {
      if (!scene_.settings.background_at_max_depth) return kBlack;
      return next.throughput *
             scene_.background.radiance(next.ray.origin, next.ray.direction, scene_.lights);
    }
    ++counter;
    branches_.add(next);
    return kBlack;
  }

  const Scene& scene_;
  const PathSegment& segment_;
  Branches& branches_;
  TraceState& state_;
};

}  // namespace

std::vector<WaitingSegment>& waiting_segments() {
  thread_local std::vector<WaitingSegment> segments;
  return segments;
}

template <bool kRich>
Color whitted_hit(const Scene& scene, const PathSegment& segment, const Hit& hit,
                  const SampleKey& key, Branches& branches, TraceState& state) {
  return WhittedHit<kRich>(scene, segment, branches, state).look(hit, key);
}

template Color whitted_hit<false>(const Scene&, const PathSegment&, const Hit&, const SampleKey&,
                                  Branches&, TraceState&);
template Color whitted_hit<true>(const Scene&, const PathSegment&, const Hit&, const SampleKey&,
                                 Branches&, TraceState&);

}  // namespace tessera
