// Part of path_rows.cpp, compiled once for each instruction set: path_tracer.cpp and path_vertex.h,
// a lane a path where light is scattered evenly.
#if defined(TESSERA_PATH_ROW_FOLLOWER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_PATH_ROW_FOLLOWER_INL_H
#undef TESSERA_PATH_ROW_FOLLOWER_INL_H
#else
#define TESSERA_PATH_ROW_FOLLOWER_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/unmade.h"
#include "renderer/integrator/lane_row-inl.h"
#include "renderer/integrator/path_front-inl.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/path_row_lights-inl.h"
#include "renderer/integrator/path_surfaces.h"
#include "renderer/integrator/path_vertex.h"
#include "renderer/integrator/row_follower-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/sampler/lane_sampler-inl.h"
#include "renderer/shading/lane_lambert-inl.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/lane_transform-inl.h"
#include "renderer/shapes/lane_triangle-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Follows paths from surface to surface.
class PathRowFollower : public RowFollower<PathFront> {
 public:
  using Surfaces = PathSurfaces;
  PathRowFollower(const Surfaces& surfaces, std::span<Color> found, TraceState& state)
      : RowFollower(surfaces.scene(), found, state), surfaces_(surfaces), lights_(scene_, state) {}

  /// The camera's rays.
  void follow(std::span<const SampleKey> keys) {
    for (size_t i = 0; i < keys.size(); ++i)
      streams_[i] = scene_.sampler->stream(keys[i].x, keys[i].y, keys[i].sample);
    if (scene_.features.rich) find_cones(keys);
    std::fill_n(now_->radiance_scale, keys.size(), 1.0);
    std::fill_n(now_->density, keys.size(), 0.0);
    follow_all([this] HWY_ATTR { step(); });
  }

 private:
  void find_cones(std::span<const SampleKey> keys) {
    const uint32_t rays = std::max(scene_.camera->lens_samples(), 1u);
    for (size_t i = 0; i < keys.size(); ++i) cones_[i] = scene_.cones.of(keys[i].sample / rays);
  }

  /// Up to the next surfaces, and what is seen there.
  void step() {
    meet();
    count_unread(
        (now_->rays.count - met_.count) *
        (VertexNumbers::kPairs - size_t{depth_ > 0}));  // the next direction is drawn ahead
    if (met_.count == 0) return;
    std::fill_n(met_.read, met_.count, ahead());
    look_at_materials();
    const bool goes_on = depth_ < scene_.settings.max_depth;
    if (goes_on) {
      draw_numbers();
      lights_.begin(now_->number);
      if (has_sampled_lights(scene_))
        lights_.choose_points(met_, [&](size_t i) { return width_at(met_.place[i]); });
      for (size_t at = 0; at < met_.even; at += kLanes) scatter(at);
      lights_.add_not_stopped(found_);
    }
    for (size_t i = met_.even; i < met_.count; ++i) {
      now_->path_length[met_.place[i]] += hits_[met_.place[i]].t;
      at_looked_up(i, [&](const SurfacePoint& point) { scatter_alone(i, point, goes_on); });
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

  // ------------------------------------------------------------------------------------- surfaces

  void meet() {
    find_hits();
    uint32_t left[RayRow::kMost], missed[RayRow::kMost + kLanes];
    size_t n = 0, misses = 0;
    for (uint32_t i = 0; i < now_->rays.count; ++i) {
      left[n] = missed[misses] = i;
      n += is_hit(i);
      misses += !is_hit(i);
    }
    if (misses > 0) add_background(missed, misses);
    state_.counters.hits += n;
    met_.count = n;
    met_.even = 0;
    // Of those that scatter otherwise the instances, and where each one's places end.
    size_t uneven = 0, groups = 0;
    uint32_t instances[RayRow::kMost], ends[RayRow::kMost];
    while (n > 0) {
      const uint32_t instance = hits_[left[0]].instance;
      const size_t begin = met_.even, end = begin + take_instance(left, n, met_.place + begin);
      if (scene_.features.rich && !surfaces_.placed(instance).has_inputs)
        state_.counters.texture_points_skipped += end - begin;
      if (!surfaces_.placed(instance).is_even) {
        std::copy(met_.place + begin, met_.place + end, uneven_ + uneven);
        uneven += end - begin;
        instances[groups] = instance;
        ends[groups++] = static_cast<uint32_t>(uneven);
        continue;
      }
      place_surfaces(instance, begin, end);
      met_.even = end;
    }
    fill_up_even();
    for (size_t group = 0, from = 0; group < groups; from = ends[group++]) {
      const size_t begin = met_.even + from, end = met_.even + ends[group];
      std::copy(uneven_ + from, uneven_ + ends[group], met_.place + begin);
      std::fill_n(met_.place + end, kLanes, met_.place[begin]);
      if (is_known(instances[group])) place_surfaces(instances[group], begin, end);
    }
    std::fill_n(met_.place + met_.count, kLanes, met_.place[0]);
  }
  /// So that the last vector is whole.
  void fill_up_even() {
    if (met_.even == 0) return;
    for (size_t i = met_.even; i % kLanes != 0; ++i) {
      for (auto* const parts :
           {&met_.surface.point, &met_.surface.error, &met_.surface.front, &met_.surface.shading})
        put(vec_at(*parts, 0), i, *parts);
    }
  }

  void place_surfaces(uint32_t instance, size_t begin, size_t end) {
    const Surfaces::Placed& placed = surfaces_.placed(instance);
    if (placed.form == Surfaces::Form::other) {
      for (size_t i = begin; i < end; ++i) place_surface(i);
      return;
    }
    for (size_t i = begin; i < end; ++i) met_.triangle[i] = hits_[met_.place[i]].primitive;
    std::fill_n(met_.triangle + end, kLanes, met_.triangle[begin]);
    for (size_t i = begin; i < end; i += kLanes) {
      const LaneIndices at = indices_of(met_.place + i);
      const Lanes u = gather_hits<&Hit::u>(hits_.data(), at);
      const Lanes v = gather_hits<&Hit::v>(hits_.data(), at);
      uint32_t bad = 0;
      LaneSurface s;
      if (placed.form == Surfaces::Form::rectangle) {
        s = surface_of(*placed.rectangle, u, v);
        place_in_world(s.point, s.error);
        s.front = s.shading = all(placed.normal);
      } else {
        s = surface_of(*placed.mesh, met_.triangle + i, u, v, bad);
        take_to_world(placed.instance->world_from_object, placed.instance->flip_normals, s);
      }
      met_.surface.store(s, i);
      for (bad &= (1u << std::min(kLanes, end - i)) - 1; bad != 0;)
        place_surface(i + take_lowest_lane(bad));
    }
  }
  void place_surface(size_t i) {
    const uint32_t place = met_.place[i];
    const SurfaceInteraction s = surface_at(scene_.instances, now_->rays.ray(place), hits_[place]);
    put(s.point - Point3{}, i, met_.surface.point);
    put(s.point_error, i, met_.surface.error);
    put(static_cast<Vec3>(s.geometric_normal), i, met_.surface.front);
    put(static_cast<Vec3>(s.shading_normal), i, met_.surface.shading);
  }

  /// Whether a surface is no more than what is placed: only lights without an extent ask what its
  /// normals stand for.
  bool is_known(uint32_t instance) const {
    return surfaces_.placed(instance).is_uniform && scene_.lights.empty();
  }
  SurfaceInteraction known_surface(size_t i, uint32_t instance) const {
    const Vec3 at = vec_at(met_.surface.point, i);
    SurfaceInteraction s;
    s.point = {at.x, at.y, at.z};
    s.point_error = vec_at(met_.surface.error, i);
    s.geometric_normal = to_normal(vec_at(met_.surface.front, i));
    s.shading_normal = to_normal(vec_at(met_.surface.shading, i));
    s.instance = instance;
    return s;
  }
  /// The points in full, for what is done one by one.
  template <typename Do>
  void at_point(size_t i, const Do& act) const {
    const uint32_t place = met_.place[i];
    const Hit& hit = hits_[place];
    const Ray ray = now_->rays.ray(place);
    if (is_known(hit.instance)) {
      SurfacePoint point(scene_, known_surface(i, hit.instance), ray.direction);
      act(point);
    } else {
      SurfacePoint point(scene_, hit.instance, ray, hit);
      act(point);
    }
  }
  /// The same with their textures, once each. The path has been measured up to here.
  template <typename Do>
  void at_looked_up(size_t i, const Do& act) {
    const uint32_t place = met_.place[i];
    at_point(i, [&](SurfacePoint& point) {
      if (surfaces_.placed(point.surface.instance).has_inputs)
        look_up_textures(scene_, now_->rays.ray(place), width_at(place), point, state_.counters);
      act(point);
    });
  }
  /// Of what a path's sample stands for.
  double width_at(uint32_t place) const {
    if (!scene_.features.rich) return 0;
    return cone_width(cones_[now_->number[place]], now_->path_length[place]);
  }

  /// Finds the colours, and adds what shines.
  void look_at_materials() {
    for (size_t at = 0; at < met_.even; at += kLanes) {
      const Lanes3 direction = gather(now_->rays.direction, indices_of(met_.place + at));
      const auto is_back = hn::Gt(dot(load(met_.surface.front, at), direction), hn::Zero(kLaneTag));
      met_.is_back[at / kLanes] = static_cast<uint8_t>(bits_of(is_back));
    }
    for (size_t i = 0; i < met_.even; ++i) {
      const uint32_t place = met_.place[i];
      now_->path_length[place] += hits_[place].t;
      const Surfaces::Placed& placed = surfaces_.placed(hits_[place].instance);
      const Surfaces::Side* const side = met_.from_behind(i) ? placed.back : placed.front;
      if (side) {
        put(side->diffuse, i, met_.diffuse);
        if (!side->shines) continue;
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
    const Color shine = emission(point);
    if (is_black(shine)) return;
    const Point3 from = Point3{} + vec_at(now_->from, place);
    const Vec3 normal = vec_at(now_->from_normal, place);
    sum_of(place) += throughput(place) * shine *
                     emission_weight(scene_, point, hits_[place].primitive, now_->density[place],
                                     {from, normal});
  }

  // -------------------------------------------------------------------------------------- numbers

  /// Beyond the camera's rays each path has drawn its next direction while that was traced.
  uint8_t ahead() const { return depth_ > 0 ? bit_of(VertexNumbers::kDirection) : uint8_t{0}; }
  bool may_end() const { return depth_ >= kSafeDepth; }

  void draw_numbers() {
    const bool on_light = has_sampled_lights(scene_), picks = on_light && picks_light(scene_);
    uint8_t read = ahead();
    if (picks) read |= bit_of(VertexNumbers::kPick);
    if (may_end()) read |= bit_of(VertexNumbers::kChoice);
    std::fill_n(met_.read, met_.even, read);
    const bool some_choose = may_end() || met_.even < met_.count;
    for (size_t at = 0; at < met_.count; at += kLanes) {
      const SampleStream* streams[kLanes];
      for (size_t lane = 0; lane < kLanes; ++lane)
        streams[lane] = &streams_[now_->number[met_.place[at + lane]]];
      const LaneStream stream(streams);
      const auto draw = [&](VertexNumbers::Pair pair) HWY_ATTR {
        return stream.pair(static_cast<SampleUse>(VertexNumbers::use_of(depth_, pair)));
      };
      const auto keep = [&](const Lanes2& pair, double(&parts)[2][RayRow::kRoom]) HWY_ATTR {
        hn::Store(pair.x, kLaneTag, parts[0] + at);
        hn::Store(pair.y, kLaneTag, parts[1] + at);
      };
      if (on_light) keep(draw(VertexNumbers::kOnLight), met_.on_light);
      keep(draw(VertexNumbers::kDirection), met_.direction);
      if (some_choose) keep(draw(VertexNumbers::kChoice), met_.choice);
      if (picks) hn::Store(draw(VertexNumbers::kPick).x, kLaneTag, met_.pick + at);
    }
  }
  void count_unread(size_t pairs) {
    if (scene_.skips.unread_numbers) {
      state_.counters.numbers_skipped += pairs;
      return;
    }
    const auto use = static_cast<SampleUse>(VertexNumbers::use_of(depth_, 0));
    for (size_t i = 0; i < pairs; ++i) keep_result(streams_[0].pair(use));
  }

  // ---------------------------------------------------------------------------------------- light

  void scatter(size_t at) {
    const LaneIndices places = indices_of(met_.place + at);
    PathBundle bundle{
        at, (1u << std::min(kLanes, met_.even - at)) - 1, met_.surface.load(at), {}, {}};
    const LaneSurface& s = bundle.surface;
    const auto is_back = mask_of(met_.is_back[at / kLanes]);
    bundle.facet = choose(is_back, negate(s.front), s.front);
    bundle.throughput = gather(now_->throughput, places);
    const Lanes3 shading = choose(is_back, negate(s.shading), s.shading);
    const Lanes3 wo = negate(gather(now_->rays.direction, places));
    const LaneLambert lambert(load(met_.diffuse, at), shading, bundle.facet, wo);
    add_direct_light(bundle, lambert);
    bounce(bundle, lambert);
  }

  void add_direct_light(const PathBundle& bundle, const LaneLambert& lambert) {
    // Without lights of other kinds all that is left to know is what stops it.
    const bool is_all = environment_share(scene_) == 0 && scene_.lights.empty();
    const Lanes zero = hn::Zero(kLaneTag);
    Lanes3 light{zero, zero, zero};
    if (has_sampled_lights(scene_)) light = lights_.brought(met_, bundle, lambert, is_all);
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
      if (to_sky > 0 && (!picks_light(scene_) || met_.pick[i] < to_sky))
        sum += vertex.from_environment(to_sky, {met_.on_light[0][i], met_.on_light[1][i]});
      vertex.add_lights(sum);
    });
    sum_of(place) += throughput(place) * sum;
  }
  template <typename Scatter, typename Do>
  void at_vertex(uint32_t place, const SurfacePoint& point, const Scatter& scatter,
                 RayOrigins& origins, const Do& act) {
    const double path_length = now_->path_length[place], width = width_at(place);
    if (scene_.features.rich) {
      act(PathVertex<true, Scatter>{scene_, point, scatter, origins, no_media_, path_length, width,
                                    state_});
    } else {
      act(PathVertex<false, Scatter>{scene_, point, scatter, origins, no_media_, path_length, width,
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

  void bounce(const PathBundle& bundle, const LaneLambert& lambert) {
    const Lanes zero = hn::Zero(kLaneTag);
    const size_t at = bundle.at;
    Lanes3 throughput = multiply(bundle.throughput, lambert.albedo());
    const Lanes scale = gather(now_->radiance_scale, indices_of(met_.place + at));
    const Lanes worth = hn::Div(greatest(throughput), scale);
    uint32_t onward = bundle.bits & bits_of(hn::Gt(worth, zero));
    if (may_end()) {
      const Lanes chance = hn::Load(kLaneTag, met_.choice[1] + at);
      const Lanes root = hn::Sqrt(worth), most = all(kMostSurvival);
      const Lanes survival = hn::IfThenElse(hn::Lt(most, root), most, root);
      const uint32_t ends = bits_of(hn::Ge(chance, survival)) & onward;
      state_.counters.roulette_ends += static_cast<uint64_t>(std::popcount(ends));
      onward &= ~ends;
      throughput = multiply(throughput, hn::Div(all(1), survival));
    }
    for (uint32_t left = onward; left != 0;)
      met_.read[at + take_lowest_lane(left)] |= bit_of(VertexNumbers::kDirection);
    Lanes3 wi;
    Lanes density;
    const Lanes2 u{hn::Load(kLaneTag, met_.direction[0] + at),
                   hn::Load(kLaneTag, met_.direction[1] + at)};
    onward &= bits_of(lambert.sample(u, wi, density));
    if (onward == 0) return;
    state_.counters.rays_reflection += static_cast<uint64_t>(std::popcount(onward));
    RayRow& rays = next_->rays;
    append(origin_towards(bundle.surface, wi), onward, rays.count, rays.origin);
    append(wi, onward, rays.count, rays.direction);
    append(throughput, onward, rays.count, next_->throughput);
    append(density, onward, next_->density + rays.count);
    append(bundle.surface.point, onward, rays.count, next_->from);
    append(bundle.facet, onward, rays.count, next_->from_normal);
    while (onward != 0) {
      const uint32_t place = met_.place[at + take_lowest_lane(onward)];
      next_->path_length[rays.count] = now_->path_length[place];
      next_->radiance_scale[rays.count] = now_->radiance_scale[place];
      next_->number[rays.count++] = now_->number[place];
    }
  }

  // ----------------------------------------------------------------------- what scatters otherwise

  /// As VertexNumbers, of those that are drawn.
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
      return {met_.pick[i_], 0};
    }

   private:
    Vec2 read(VertexNumbers::Pair pair, const double (&of)[2][RayRow::kRoom]) const {
      met_.read[i_] |= bit_of(pair);
      return {of[0][i_], of[1][i_]};
    }
    Met& met_;
    size_t i_;
  };

  void scatter_alone(size_t i, const SurfacePoint& point, bool goes_on) {
    const uint32_t place = met_.place[i];
    add_emission(place, point);
    if (!goes_on || point.material->model == MaterialModel::unlit) return;
    const Bsdf bsdf(bsdf_point(place, point, surface_diffuse(point)));
    RayOrigins origins(point.surface);
    const DrawnNumbers numbers(met_, i);
    Color throughput = this->throughput(place);
    if (bsdf.is_smooth()) {
      at_vertex(place, point, bsdf, origins, [&](const auto& vertex) {
        sum_of(place) += throughput * vertex.direct_light(numbers);
      });
    }
    BsdfSample sample;
    double radiance_scale = now_->radiance_scale[place];
    if (!choose_way(bsdf, depth_, numbers, throughput, radiance_scale, sample, state_.counters))
      return;
    RayRow& rays = next_->rays;
    const size_t at = rays.count++;
    put(origins.towards(sample.wi) - Point3{}, at, rays.origin);
    put(sample.wi, at, rays.direction);
    put(throughput, at, next_->throughput);
    next_->density[at] = sample.is_mirror ? 0 : sample.density;
    put(point.surface.point - Point3{}, at, next_->from);
    put(point.geometric_normal, at, next_->from_normal);
    next_->path_length[at] = now_->path_length[place];
    next_->radiance_scale[at] = radiance_scale;
    next_->number[at] = now_->number[place];
  }

  const Surfaces& surfaces_;
  Met met_;
  PathRowLights lights_;
  Unmade<SampleStream, RayRow::kMost> streams_;
  uint32_t uneven_[RayRow::kMost];
  Unmade<Camera::PixelCone, RayRow::kMost> cones_;  ///< of the paths, where something is rich
  const Media no_media_{};
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
