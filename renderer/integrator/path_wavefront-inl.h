// Part of path_batches.cpp, compiled once for each instruction set: path tracing, a lane a path
// where light is scattered by Lambert's law, else by path_vertex.h.
#if defined(TESSERA_PATH_WAVEFRONT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PATH_WAVEFRONT_INL_H
#undef TESSERA_PATH_WAVEFRONT_INL_H
#else
#define TESSERA_PATH_WAVEFRONT_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/uninitialized.h"
#include "renderer/integrator/lane_batch-inl.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/path_rays-inl.h"
#include "renderer/integrator/path_surfaces.h"
#include "renderer/integrator/path_vertex.h"
#include "renderer/integrator/path_wavefront_hits-inl.h"
#include "renderer/integrator/path_wavefront_lights-inl.h"
#include "renderer/integrator/wavefront-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/sampler/lane_sampler-inl.h"
#include "renderer/shading/lambert_lanes-inl.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/lane_transform-inl.h"
#include "renderer/shapes/lane_triangle-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Follows paths from surface to surface.
class PathWavefront : public PathWavefrontHits {
 public:
  using Surfaces = PathSurfaces;
  PathWavefront(const Surfaces& surfaces, std::span<Color> found, TraceState& state)
      : PathWavefrontHits(surfaces, found, state),
        lights_(scene_, surfaces.passes(), state),
        passes_(surfaces.passes()) {}

  /// The camera's rays.
  void follow(std::span<const SampleKey> keys) {
    for (size_t i = 0; i < keys.size(); ++i)
      streams_[i] = scene_.sampler->stream(keys[i].x, keys[i].y, keys[i].sample);
    find_cones(keys);
    std::fill_n(now_->radiance_scale, keys.size(), 1.0);
    std::fill_n(now_->density, keys.size(), 0.0);
    if (passes_) {
      std::fill_n(now_->view_distance, keys.size(), 0.0);
      std::fill_n(now_->bounces, keys.size(), 0u);
      std::fill_n(now_->media, keys.size(), surfaces_.at_camera());
    }
    follow_all([this] HWY_ATTR { step(); });
  }

 private:
  /// As PathWavefrontLights asks for it, of surfaces that nothing is filled behind.
  auto transmittance_along() {
    return [this](uint32_t place, const Ray& ray) {
      const Media& inside = now_->media[place];
      const double width = width_at(place);
      return scene_.features.rich ? ray_transmittance<true>(scene_, ray, inside, width, state_)
                                  : ray_transmittance<false>(scene_, ray, inside, width, state_);
    };
  }

  /// Up to the next surfaces, and what is seen there.
  void step() {
    // With alpha, paths of one front differ in bounces: at the limit each is asked by itself.
    const bool goes_on = vertex_ < scene_.settings.max_depth;
    const bool alone = (passes_ && !goes_on) || is_foggy();
    meet(alone, [&](uint32_t* places, size_t count) HWY_ATTR { add_background(places, count); });
    count_unread(
        (now_->rays.count - met_.count) *
        (VertexNumbers::kPairs - size_t{vertex_ > 0}));  // the next direction is drawn ahead
    if (met_.count == 0) return;
    std::fill_n(met_.read, met_.count, ahead());
    if (passes_) absorb();
    look_at_materials();
    if (goes_on || passes_) {
      draw_numbers();
      lights_.begin(now_->number);
      if (has_sampled_lights(scene_))
        lights_.choose_points(met_, [&](size_t i) { return width_at(met_.place[i]); });
      for (size_t at = 0; at < met_.even; at += kLanes) scatter(at);
      lights_.add_not_stopped(found_, transmittance_along());
    }
    for (size_t i = met_.even; i < met_.count; ++i) {
      now_->path_length[met_.place[i]] += hits_[met_.place[i]].t;
      at_looked_up(i, [&](const SurfacePoint& point) { scatter_alone(i, point); });
    }
    size_t read = 0;
    for (size_t i = 0; i < met_.count; ++i)
      read += static_cast<size_t>(std::popcount(uint32_t{met_.read[i]}));
    count_unread(met_.count * VertexNumbers::kPairs - read);
  }

  /// To paths that meet nothing; there is room behind `places`.
  void add_background(uint32_t* places, size_t count) {
    look_beyond(places, count, [&](uint32_t place, const Color& seen, const Vec2* at) {
      const Vec3 direction = vec_at(now_->rays.direction, place);
      sum_of(place) +=
          throughput(place) * seen * background_weight(scene_, now_->density[place], direction, at);
    });
  }

  // ------------------------------------------------------------------------------------- materials

  /// Finds the colours, and adds what is emitted.
  void look_at_materials() {
    for (size_t at = 0; at < met_.even; at += kLanes) {
      const Lanes3 direction = gather(now_->rays.direction, indices_of(met_.place + at));
      const auto is_back = hn::Gt(dot(load(met_.surface.front, at), direction), hn::Zero(kLaneTag));
      met_.is_back[at / kLanes] = static_cast<uint8_t>(movemask(is_back));
    }
    for (size_t i = 0; i < met_.even; ++i) {
      const uint32_t place = met_.place[i];
      now_->path_length[place] += hits_[place].t;
      const Surfaces::Placed& placed = surfaces_.placed(hits_[place].instance);
      const Surfaces::Side* const side = met_.from_behind(i) ? placed.back : placed.front;
      if (side) {
        put(side->diffuse, i, met_.diffuse);
        if (!side->emits) continue;
      }
      at_looked_up(i, [&](const SurfacePoint& point) { look_at_material(i, place, point); });
    }
    for (size_t i = met_.even; i % kLanes != 0; ++i) put(kWhite, i, met_.diffuse);
  }
  void look_at_material(size_t i, uint32_t place, const SurfacePoint& point) {
    put(surface_diffuse(point), i, met_.diffuse);
    put(point.is_back ? -point.normal : point.normal, i, met_.surface.shading);
    add_emission(place, point);
  }
  void add_emission(uint32_t place, const SurfacePoint& point) {
    const Color emitted = emission(point);
    if (is_black(emitted)) return;
    const Point3 from = Point3{} + vec_at(now_->from, place);
    const Vec3 normal = vec_at(now_->from_normal, place);
    sum_of(place) += throughput(place) * emitted *
                     emission_weight(scene_, point, hits_[place].primitive, now_->density[place],
                                     {from, normal});
  }

  // -------------------------------------------------------------------------------------- numbers

  /// Beyond the camera's rays each path has drawn its next direction while that was traced.
  uint8_t ahead() const { return vertex_ > 0 ? bit_of(VertexNumbers::kDirection) : uint8_t{0}; }
  bool may_end() const { return vertex_ >= kSafeDepth; }

  void draw_numbers() {
    const bool on_light = has_sampled_lights(scene_), picks = on_light && picks_light(scene_);
    uint8_t read = ahead();
    if (picks) read |= bit_of(VertexNumbers::kPick);
    if (may_end()) read |= bit_of(VertexNumbers::kChoice);
    std::fill_n(met_.read, met_.even, read);
    for (size_t at = 0; at < met_.count; at += kLanes) {
      const bool some_alone = at + kLanes > met_.even && met_.even < met_.count;
      const SampleStream* streams[kLanes];
      for (size_t lane = 0; lane < kLanes; ++lane)
        streams[lane] = &streams_[now_->number[met_.place[at + lane]]];
      const LaneStream stream(streams);
      const auto draw = [&](VertexNumbers::Pair pair) HWY_ATTR {
        return stream.pair(static_cast<SampleUse>(VertexNumbers::use_of(vertex_, pair)));
      };
      const auto keep = [&](const Lanes2& pair, double(&parts)[2][RayBatch::kPadded]) HWY_ATTR {
        hn::Store(pair.x, kLaneTag, parts[0] + at);
        hn::Store(pair.y, kLaneTag, parts[1] + at);
      };
      if (on_light) keep(draw(VertexNumbers::kOnLight), met_.on_light);
      keep(draw(VertexNumbers::kDirection), met_.direction);
      if (may_end() || some_alone) keep(draw(VertexNumbers::kChoice), met_.choice);
      if (picks || (passes_ && some_alone)) keep(draw(VertexNumbers::kPick), met_.pick);
    }
  }
  void count_unread(size_t pairs) { state_.counters.numbers_skipped += pairs; }

  // ---------------------------------------------------------------------------------------- light

  void scatter(size_t at) {
    const LaneIndices places = indices_of(met_.place + at);
    PathBundle bundle{
        at, (1u << std::min(kLanes, met_.even - at)) - 1, met_.surface.load(at), {}, {}};
    const LaneSurface& s = bundle.surface;
    const auto is_back = mask_of(met_.is_back[at / kLanes]);
    bundle.facet = select(is_back, -s.front, s.front);
    bundle.throughput = gather(now_->throughput, places);
    const Lanes3 shading = select(is_back, -s.shading, s.shading);
    const Lambert lambert(load(met_.diffuse, at), shading, bundle.facet);
    add_direct_light(bundle, lambert);
    bounce(bundle, lambert);
  }

  void add_direct_light(const PathBundle& bundle, const Lambert& lambert) {
    // Without lights of other kinds all that is left to know is what stops it.
    const bool is_all = environment_share(scene_) == 0 && scene_.lights.empty();
    const Lanes zero = hn::Zero(kLaneTag);
    Lanes3 light{zero, zero, zero};
    if (has_sampled_lights(scene_))
      light = lights_.brought(met_, bundle, lambert, is_all, transmittance_along());
    if (is_all) return;
    Stored3 sums(light);
    for (uint32_t left = bundle.bits; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      at_point(bundle.at + lane, [&](SurfacePoint& point) {
        add_light_from_others(bundle.at + lane, point, sums.color(lane));
      });
    }
  }
  /// `sum` is what comes from area lights.
  void add_light_from_others(size_t i, SurfacePoint& point, Color sum) {
    const uint32_t place = met_.place[i];
    const Vec3 shading = vec_at(met_.surface.shading, i);  // in relief
    point.normal = point.is_back ? -shading : shading;
    const LambertBsdf lambert(bsdf_point(place, point, color_at(met_.diffuse, i)));
    RayOrigins origins(point.surface);
    at_vertex(place, point, lambert, origins, [&](const auto& vertex) {
      const double to_sky = environment_share(scene_);
      if (to_sky > 0 && (!picks_light(scene_) || met_.pick[0][i] < to_sky))
        sum += vertex.from_environment(to_sky, {met_.on_light[0][i], met_.on_light[1][i]});
      vertex.add_lights(sum);
    });
    sum_of(place) += throughput(place) * sum;
  }
  template <typename Scatter, typename Do>
  void at_vertex(uint32_t place, const SurfacePoint& point, const Scatter& scatter,
                 RayOrigins& origins, const Do& act) {
    const double path_length = now_->path_length[place], width = width_at(place);
    const Media& media = now_->media[place];
    if (scene_.features.rich) {
      act(PathVertex<true, Scatter>{scene_, point, scatter, origins, media, path_length, width,
                                    state_});
    } else {
      act(PathVertex<false, Scatter>{scene_, point, scatter, origins, media, path_length, width,
                                     state_});
    }
  }
  BsdfPoint bsdf_point(uint32_t place, const SurfacePoint& point, const Color& diffuse) const {
    return {.material = *point.material,
            .diffuse = diffuse,
            .normal = point.normal,
            .geometric_normal = point.geometric_normal,
            .wo = -vec_at(now_->rays.direction, place),
            .from_inside = point.is_back};
  }

  // --------------------------------------------------------------------------------------- bounce

  void bounce(const PathBundle& bundle, const Lambert& lambert) {
    const Lanes zero = hn::Zero(kLaneTag);
    const size_t at = bundle.at;
    Lanes3 throughput = bundle.throughput * lambert.albedo();
    const Lanes scale = gather(now_->radiance_scale, indices_of(met_.place + at));
    const Lanes worth = max_component(throughput) / scale;
    uint32_t onward = bundle.bits & movemask(hn::Gt(worth, zero));
    if (may_end()) {
      const Lanes chance = hn::Load(kLaneTag, met_.choice[1] + at);
      const Lanes root = hn::Sqrt(worth), one = broadcast(1);
      Lanes survival = hn::IfThenElse(hn::Lt(one, root), one, root);
      if (passes_) survival = hn::IfThenElse(mask_of(safe(at)), one, survival);
      const uint32_t ends = movemask(hn::Ge(chance, survival)) & onward;
      state_.counters.roulette_ends += static_cast<uint64_t>(std::popcount(ends));
      onward &= ~ends;
      throughput = throughput * (one / survival);
    }
    for (uint32_t left = onward; left != 0;)
      met_.read[at + take_lowest_lane(left)] |= bit_of(VertexNumbers::kDirection);
    Lanes3 wi;
    Lanes density;
    const Lanes2 u{hn::Load(kLaneTag, met_.direction[0] + at),
                   hn::Load(kLaneTag, met_.direction[1] + at)};
    onward &= movemask(lambert.sample(u, wi, density));
    if (onward == 0) return;
    state_.counters.rays_reflection += static_cast<uint64_t>(std::popcount(onward));
    RayBatch& rays = next_->rays;
    append(origin_towards(bundle.surface, wi), onward, rays.count, rays.origin);
    append(wi, onward, rays.count, rays.direction);
    append(throughput, onward, rays.count, next_->throughput);
    append(density, onward, next_->density + rays.count);
    append(bundle.surface.point, onward, rays.count, next_->from);
    append(bundle.facet, onward, rays.count, next_->from_normal);
    while (onward != 0) {
      const uint32_t place = met_.place[at + take_lowest_lane(onward)];
      carry(place, rays.count++, 1);
    }
  }
  /// A bit for each lane whose path no roulette ends yet.
  uint32_t safe(size_t at) const {
    uint32_t bits = 0;
    for (size_t lane = 0; lane < kLanes; ++lane)
      bits |= uint32_t{now_->bounces[met_.place[at + lane]] < kSafeDepth} << lane;
    return bits;
  }
  /// What a path keeps on its way on, which has so many bounces more.
  void carry(uint32_t place, size_t at, uint32_t bounces) {
    next_->path_length[at] = now_->path_length[place];
    next_->radiance_scale[at] = now_->radiance_scale[place];
    next_->number[at] = now_->number[place];
    if (!passes_) return;
    next_->bounces[at] = now_->bounces[place] + bounces;
    next_->view_distance[at] = bounces > 0 ? 0 : now_->view_distance[place];
    next_->media[at] = now_->media[place];
  }

  // ----------------------------------------------------------------------- what scatters otherwise

  /// The numbers of one path, which tells those that are read.
  class DrawnNumbers {
   public:
    DrawnNumbers(Met& met, size_t i) : met_(met), i_(i) {}
    Vec2 on_light() const {
      direction();
      return read(VertexNumbers::kOnLight, met_.on_light);
    }
    Vec2 direction() const { return read(VertexNumbers::kDirection, met_.direction); }
    Vec2 choice() const { return read(VertexNumbers::kChoice, met_.choice); }
    Vec2 pick() const {
      met_.read[i_] |= bit_of(VertexNumbers::kPick);
      return {met_.pick[0][i_], met_.pick[1][i_]};
    }

   private:
    Vec2 read(VertexNumbers::Pair pair, const double (&of)[2][RayBatch::kPadded]) const {
      met_.read[i_] |= bit_of(pair);
      return {of[0][i_], of[1][i_]};
    }
    Met& met_;
    size_t i_;
  };

  void scatter_alone(size_t i, const SurfacePoint& point) {
    const uint32_t place = met_.place[i];
    const DrawnNumbers numbers(met_, i);
    if (passes_) {
      note_media_before(now_->media[place], point);
      absorb(place);
      if (is_foggy()) now_->view_distance[place] += hits_[place].t;
      if (passes_straight(place, point, numbers)) return;
      if (is_foggy() && now_->density[place] == 0) enter_fog(place);
    }
    add_emission(place, point);
    const uint32_t bounces = passes_ ? now_->bounces[place] : vertex_;
    if (bounces >= scene_.settings.max_depth || !point.material->is_lit()) return;
    const Bsdf bsdf(bsdf_point(place, point, surface_diffuse(point)));
    RayOrigins origins(point.surface);
    Color throughput = this->throughput(place);
    if (bsdf.is_smooth()) {
      at_vertex(place, point, bsdf, origins, [&](const auto& vertex) {
        sum_of(place) += throughput * vertex.direct_light(numbers);
      });
    }
    BsdfSample sample;
    double radiance_scale = now_->radiance_scale[place];
    if (!choose_way(bsdf, bounces, numbers, throughput, radiance_scale, sample, state_.counters))
      return;
    RayBatch& rays = next_->rays;
    const size_t at = rays.count++;
    put(origins.towards(sample.wi) - Point3{}, at, rays.origin);
    put(sample.wi, at, rays.direction);
    put(throughput, at, next_->throughput);
    next_->density[at] = sample.is_specular ? 0 : sample.density;
    put(point.surface.point - Point3{}, at, next_->from);
    put(point.geometric_normal, at, next_->from_normal);
    carry(place, at, 1);
    next_->radiance_scale[at] = radiance_scale;
    if (passes_ && sample.is_transmitted) pass_into(next_->media[at], point);
  }

  // ------------------------------------------------------------------- what is passed, and absorbs

  /// What media take of paths up to where they scatter evenly; the surface tells nothing of them.
  void absorb() {
    for (size_t i = 0; i < met_.even; ++i) absorb(met_.place[i]);
  }
  void absorb(uint32_t place) {
    const Color& absorption = now_->media[place].absorption();
    if (is_black(absorption)) return;
    put(throughput(place) * transmittance(absorption, hits_[place].t), place, now_->throughput);
  }
  bool is_foggy() const { return scene_.fog.kind != FogKind::none; }
  /// As far as the surface is seen; light that comes to it from all sides is as if there were none.
  void enter_fog(uint32_t place) {
    const double clearness = scene_.fog.clearness(now_->view_distance[place]);
    sum_of(place) += throughput(place) * scene_.fog.color * (1 - clearness);
    put(throughput(place) * clearness, place, now_->throughput);
  }
  /// Whether the path goes on through the surface as if it were not there.
  bool passes_straight(uint32_t place, const SurfacePoint& point, const DrawnNumbers& numbers) {
    if (!goes_straight(point, numbers)) return false;
    ++state_.counters.rays_refraction;
    if (vertex_ + 1 >= kMaxPasses) {
      ++state_.counters.paths_cut;
      return true;
    }
    const Ray on = spawn_ray(point.surface, vec_at(now_->rays.direction, place));
    RayBatch& rays = next_->rays;
    const size_t at = rays.count++;
    put(on.origin - Point3{}, at, rays.origin);
    put(on.direction, at, rays.direction);
    rays.t_max[at] = now_->rays.t_max[place] - hits_[place].t;
    put(throughput(place), at, next_->throughput);
    next_->density[at] = now_->density[place];
    put(vec_at(now_->from, place), at, next_->from);
    put(vec_at(now_->from_normal, place), at, next_->from_normal);
    carry(place, at, 0);
    pass_into(next_->media[at], point);
    return true;
  }

  PathWavefrontLights lights_;
  Uninitialized<SampleStream, RayBatch::kMost> streams_;
  const bool passes_;  ///< PathSurfaces::passes()
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
