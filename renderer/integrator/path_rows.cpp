#include "renderer/integrator/path_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <new>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/unmade.h"
#include "renderer/integrator/path_light.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/math/targets.h"

// This file is compiled once for each instruction set, as bvh_kernels.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/integrator/path_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/integrator/lane_row-inl.h"
#include "renderer/integrator/lane_scatter-inl.h"
#include "renderer/integrator/lane_surface-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/sampler/lane_sampler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Paths that have met as many surfaces.
struct PathFront {
  RayRow rays;
  alignas(64) double throughput[3][RayRow::kRoom];
  alignas(64) double path_length[RayRow::kRoom];
  // Of the last bounce, where there was one.
  alignas(64) double density[RayRow::kRoom];
  alignas(64) double from[3][RayRow::kRoom], from_normal[3][RayRow::kRoom];
  uint32_t number[PathRows::kMost];  ///< of the path
};

/// Some paths at their next surfaces, a lane each. What fills the vector up is one of them again.
struct PathBundle {
  const uint32_t* places;  ///< in the front
  uint32_t bits;           ///< of lanes that are paths, the first ones
  const LaneStream& stream;
  Lanes2 way_on;                       ///< the numbers of VertexNumbers::direction()
  std::array<uint8_t, kLanes> read{};  ///< pairs that each asked for, a bit each
  Lanes3 direction, throughput;
  LaneSurface surface;
  Lanes3 facet;  ///< the geometric normal, towards the viewer

  PathBundle(const uint32_t* front_places, uint32_t path_bits, const LaneStream& numbers)
      : places(front_places), bits(path_bits), stream(numbers) {}
};

/// The points of a bundle, made one by one.
class BundlePoints {
 public:
  BundlePoints() {}   // NOLINT(modernize-use-equals-default): that would be deleted
  ~BundlePoints() {}  // NOLINT(modernize-use-equals-default)
  BundlePoints(const BundlePoints&) = delete;
  BundlePoints& operator=(const BundlePoints&) = delete;
  template <typename... Of>
  SurfacePoint& make(size_t lane, const Of&... of) {
    return *::new (static_cast<void*>(&points_[lane])) SurfacePoint(of...);
  }
  SurfacePoint& operator[](size_t lane) { return points_[lane]; }

 private:
  static_assert(std::is_trivially_destructible_v<SurfacePoint>);
  union {
    SurfacePoint points_[kLanes];
  };
};

class PathRowFollower {
 public:
  PathRowFollower(const Scene& scene, std::span<Color> found, TraceState& state)
      : scene_(scene), found_(found), state_(state) {}

  void follow(std::span<const Ray> rays, std::span<const SampleKey> keys) {
    RayRow& row = now_->rays;
    row.begin(rays[0].t_min, rays[0].t_max);
    row.count = rays.size();
    for (size_t i = 0; i < rays.size(); ++i) {
      streams_[i] = scene_.sampler->stream(keys[i].x, keys[i].y, keys[i].sample);
      for (int axis = 0; axis < 3; ++axis) {
        row.origin[axis][i] = rays[i].origin[axis];
        row.direction[axis][i] = rays[i].direction[axis];
        now_->throughput[axis][i] = 1;
      }
      now_->path_length[i] = now_->density[i] = 0;
    }
    std::iota(now_->number, now_->number + rays.size(), 0u);
    std::ranges::fill(found_, kBlack);
    state_.counters.rays_primary += rays.size();
    for (; now_->rays.count > 0; ++depth_) {
      next_->rays.begin();
      step();
      std::swap(now_, next_);
    }
  }

 private:
  /// Up to the next surfaces, and what is seen there.
  void step() {
    const size_t count = now_->rays.count;
    scene_.surfaces->closest_hits(now_->rays, {hits_.data(), count}, state_.counters.traversal);
    uint32_t met[PathRows::kMost + kLanes];  // with room for what fills a vector up
    size_t n = 0;
    for (uint32_t i = 0; i < count; ++i) {
      met[n] = i;
      const bool is_hit = hits_[i].t < std::numeric_limits<double>::infinity();
      n += is_hit;
      if (!is_hit) add_background(i);
    }
    state_.counters.hits += n;
    count_numbers_of_missed(count - n);
    std::fill_n(met + n, kLanes, met[0]);
    for (size_t i = 0; i < n; i += kLanes) shade(met + i, std::min(kLanes, n - i));
  }

  Color& sum_at(uint32_t place) { return found_[now_->number[place]]; }
  static Color color_at(const double (&parts)[3][RayRow::kRoom], uint32_t place) {
    return {parts[0][place], parts[1][place], parts[2][place]};
  }
  static Vec3 vec_at(const double (&parts)[3][RayRow::kRoom], uint32_t place) {
    return {parts[0][place], parts[1][place], parts[2][place]};
  }
  void add_background(uint32_t place) {
    const Ray ray = now_->rays.ray(place);
    Color& sum = sum_at(place);
    sum += color_at(now_->throughput, place) *
           scene_.background.radiance(ray.origin, ray.direction, scene_.lights) *
           background_weight(scene_, now_->density[place], ray.direction);
  }

  // -------------------------------------------------------------------------------------- numbers

  /// Beyond the camera's rays each has drawn its next direction ahead.
  void count_numbers_of_missed(size_t count) {
    const size_t drawn = depth_ > 0 ? 1 : 0;
    count_unread(count * (VertexNumbers::kPairs - drawn));
  }
  void count_numbers(const PathBundle& bundle) {
    size_t read = 0, paths = 0;
    for (uint32_t left = bundle.bits; left != 0; ++paths)
      read += static_cast<size_t>(std::popcount(bundle.read[take_lowest_lane(left)]));
    count_unread(paths * VertexNumbers::kPairs - read);
  }
  void count_unread(size_t pairs) {
    if (scene_.skips.unread_numbers) {
      state_.counters.numbers_skipped += pairs;
      return;
    }
    const auto use = static_cast<SampleUse>(VertexNumbers::use_of(depth_, 0));
    for (size_t i = 0; i < pairs; ++i) keep_result(streams_[0].pair(use));
  }
  Lanes2 numbers(const PathBundle& bundle, uint32_t pair) const {
    return bundle.stream.pair(static_cast<SampleUse>(VertexNumbers::use_of(depth_, pair)));
  }
  /// Notes that the paths in `lanes` asked for them.
  Lanes2 numbers(PathBundle& bundle, uint32_t pair, uint32_t lanes) const {
    while (lanes != 0) bundle.read[take_lowest_lane(lanes)] |= static_cast<uint8_t>(1u << pair);
    return numbers(bundle, pair);
  }
  static void note_direction(PathBundle& bundle, uint32_t lanes) {
    while (lanes != 0)
      bundle.read[take_lowest_lane(lanes)] |= uint8_t{1} << VertexNumbers::kDirection;
  }

  // ------------------------------------------------------------------------------------- surfaces

  void shade(const uint32_t* places, size_t count) {
    const SampleStream* streams[kLanes];
    for (size_t lane = 0; lane < kLanes; ++lane)
      streams[lane] = &streams_[now_->number[places[lane]]];
    const LaneStream stream(streams);
    PathBundle bundle(places, (1u << count) - 1, stream);
    const LaneIndices at = indices_of(places);
    bundle.direction = gather(now_->rays.direction, at);
    bundle.throughput = gather(now_->throughput, at);
    bundle.way_on = numbers(bundle, VertexNumbers::kDirection);
    if (depth_ > 0) note_direction(bundle, bundle.bits);
    BundlePoints points;
    Stored3 diffuse, shading;
    make_points(bundle, points, diffuse, shading);
    if (depth_ < scene_.settings.max_depth) {
      const LaneLambert scatter(diffuse.load(), shading.load(), bundle.facet,
                                negate(bundle.direction));
      add_direct_light(bundle, points, scatter);
      bounce(bundle, scatter);
    }
    count_numbers(bundle);
  }

  /// And adds what shines there.
  void make_points(PathBundle& bundle, BundlePoints& points, Stored3& diffuse, Stored3& shading) {
    Stored3 point, error, front, facet;
    const auto count = static_cast<size_t>(std::popcount(bundle.bits));
    size_t lane = 0;
    do {
      const uint32_t place = bundle.places[lane];
      const Hit& hit = hits_[place];
      const SurfacePoint& here =
          points.make(lane, scene_, hit.instance, now_->rays.ray(place), hit);
      now_->path_length[place] += hit.t;
      const Color shine = emission(here);
      if (!is_black(shine)) [[unlikely]] {
        sum_at(place) += color_at(now_->throughput, place) * shine *
                         emission_weight(scene_, here, now_->density[place],
                                         Point3{} + vec_at(now_->from, place),
                                         vec_at(now_->from_normal, place));
      }
      point.put(lane, here.surface.point - Point3{});
      error.put(lane, here.surface.point_error);
      front.put(lane, static_cast<Vec3>(here.surface.geometric_normal));
      facet.put(lane, here.geometric_normal);
      shading.put(lane, here.normal);
      const Color color = surface_diffuse(here);
      diffuse.put(lane, {color.r, color.g, color.b});
    } while (++lane < count);
    for (Stored3* const of : {&point, &error, &front, &facet, &diffuse, &shading})
      of->fill_from(count);
    bundle.surface = {point.load(), error.load(), front.load(), shading.load()};
    bundle.facet = facet.load();
  }

  // ---------------------------------------------------------------------------------------- light

  /// A light's point, of each path that may see it.
  struct LightPoints {
    uint32_t bits = 0;
    Stored3 point{}, error{}, normal{}, front{}, back{};
    alignas(64) double density[kLanes] = {};
  };

  void add_direct_light(PathBundle& bundle, BundlePoints& points, const LaneLambert& scatter) {
    const double to_sky = environment_share(scene_);
    const Lanes zero = hn::Zero(kLaneTag);
    Lanes3 light{zero, zero, zero};
    if (to_sky > 0 || !scene_.area_lights.empty()) {
      LightPoints there;
      Stored3 from_sky(light);
      choose_lights(bundle, points, to_sky, there, from_sky);
      light = from_sky.load();
      if (there.bits != 0) light = add(light, from_area_lights(bundle, points, scatter, there));
    }
    if (!scene_.lights.empty()) light = with_lights(bundle, points, light);
    const Stored3 each(multiply(bundle.throughput, light));
    for (uint32_t left = bundle.bits; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      sum_at(bundle.places[lane]) += each.color(lane);
    }
  }

  LambertBsdf scatter_at(const PathBundle& bundle, size_t lane, const SurfacePoint& point) const {
    return LambertBsdf({.material = *point.material,
                        .diffuse = surface_diffuse(point),
                        .normal = point.normal,
                        .geometric_normal = point.geometric_normal,
                        .wo = -vec_at(now_->rays.direction, bundle.places[lane]),
                        .from_inside = point.is_back});
  }

  void choose_lights(PathBundle& bundle, BundlePoints& points, double to_sky, LightPoints& there,
                     Stored3& from_sky) {
    const AreaLights& lights = scene_.area_lights;
    const bool picks = to_sky < 1 && (to_sky > 0 || lights.size() > 1);
    alignas(64) double which[kLanes] = {}, x[kLanes], y[kLanes];
    if (picks) hn::Store(numbers(bundle, VertexNumbers::kPick, bundle.bits).x, kLaneTag, which);
    const Lanes2 on_light = numbers(bundle, VertexNumbers::kOnLight);
    hn::Store(on_light.x, kLaneTag, x);
    hn::Store(on_light.y, kLaneTag, y);
    for (uint32_t left = bundle.bits; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      const SurfacePoint& point = points[lane];
      const auto chosen = [&] {
        bundle.read[lane] |=
            uint8_t{1} << VertexNumbers::kOnLight | uint8_t{1} << VertexNumbers::kDirection;
        return Vec2{x[lane], y[lane]};
      };
      if (which[lane] < to_sky) {
        EnvironmentSampler::Sample sky = scene_.environment->sample(chosen());
        sky.density *= to_sky;
        RayOrigins origins(point.surface);
        const Color color = light_from_environment<false>(
            scene_, sky, point, scatter_at(bundle, lane, point), origins, {}, 0, state_);
        from_sky.put(lane, {color.r, color.g, color.b});
        continue;
      }
      const double u = (which[lane] - to_sky) / (1 - to_sky);
      const LightTree::Pick pick =
          lights.tree().pick(point.surface.point, point.geometric_normal, u);
      const AreaLight& light = lights[pick.index];
      if (scene_.skips.dark_shadow_rays && light.is_dark_from(point.surface.point)) {
        ++state_.counters.shadow_rays_skipped;
        continue;
      }
      SurfaceSample sample;
      const double density = light.sampler->sample(point.surface.point, chosen(), sample) *
                             pick.probability * (1 - to_sky);
      if (!(density > 0)) continue;
      there.bits |= 1u << lane;
      there.density[lane] = density;
      there.point.put(lane, sample.point - Point3{});
      there.error.put(lane, sample.point_error);
      there.normal.put(lane, sample.normal);
      there.front.put(lane, {light.front.r, light.front.g, light.front.b});
      there.back.put(lane, {light.back.r, light.back.g, light.back.b});
    }
  }

  Lanes3 from_area_lights(const PathBundle& bundle, BundlePoints& points,
                          const LaneLambert& scatter, const LightPoints& there) {
    const Lanes zero = hn::Zero(kLaneTag);
    const Lanes3 place = there.point.load(), normal = there.normal.load();
    const LaneSurface& here = bundle.surface;
    const Lanes3 way = subtract(place, here.point), wi = normalize(way);
    const auto in_front = hn::Lt(dot(wi, normal), zero);
    const Lanes3 shine = choose(in_front, there.front.load(), there.back.load());
    LaneValue value = scatter.evaluate(wi);
    const auto shines_not = is_black(shine);
    value.density = hn::IfThenZeroElse(shines_not, value.density);
    const auto is_dark = hn::Or(shines_not, is_black(value.share));
    const uint32_t dark = bits_of(is_dark) & there.bits;
    uint32_t asked = there.bits;
    if (scene_.skips.dark_shadow_rays) {
      state_.counters.shadow_rays_skipped += static_cast<uint64_t>(std::popcount(dark));
      asked &= ~dark;
    }
    // As point_visibility() does: the stretch ends before the light's own surface.
    const Lanes3 back = subtract(here.point, place);
    const auto behind = hn::Lt(dot(back, normal), zero);
    const Lanes3 side = choose(behind, negate(normal), normal);
    const Lanes lift = hn::Add(dot(abs(side), there.error.load()),
                               hn::Mul(all(kLiftRoundings), sum(abs(back))));
    const Lanes3 origin = origin_towards(here, negate(back));
    const Stored3 origins(origin),
        ways(subtract(add(place, multiply(side, lift)), origin));
    uint32_t seen = 0;
    while (asked != 0) {
      const size_t lane = take_lowest_lane(asked);
      const Ray ray{origins.point(lane), ways.vec(lane), 0, 1};
      const bool stops =
          is_black(ray_visibility<false>(scene_, points[lane], ray, {}, 0, state_));
      seen |= uint32_t{!stops} << lane;
    }
    const Lanes density = hn::Load(kLaneTag, there.density);
    const Lanes weight = power_heuristic(density, value.density);
    const Lanes3 brought =
        multiply(multiply(shine, value.share), hn::Div(weight, density));
    const Lanes3 none{zero, zero, zero};
    return choose(mask_of(seen & ~dark), brought, none);
  }

  Lanes3 with_lights(PathBundle& bundle, BundlePoints& points, const Lanes3& so_far) {
    Stored3 sums(so_far);
    for (uint32_t left = bundle.bits; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      const SurfacePoint& point = points[lane];
      RayOrigins origins(point.surface);
      Color sum = sums.color(lane);
      add_lights<false>(scene_, point, scatter_at(bundle, lane, point), origins, {},
                        now_->path_length[bundle.places[lane]], 0, state_, sum);
      sums.put(lane, {sum.r, sum.g, sum.b});
    }
    return sums.load();
  }

  // --------------------------------------------------------------------------------------- bounce

  void bounce(PathBundle& bundle, const LaneLambert& scatter) {
    const Lanes zero = hn::Zero(kLaneTag);
    Lanes3 throughput = multiply(bundle.throughput, scatter.albedo());
    const Lanes worth = greatest(throughput);
    uint32_t onward = bundle.bits & bits_of(hn::Gt(worth, zero));
    if (depth_ >= kSafeDepth) {
      const Lanes chance = numbers(bundle, VertexNumbers::kChoice, bundle.bits).y;
      const Lanes root = hn::Sqrt(worth), most = all(kMostSurvival);
      const Lanes survival = hn::IfThenElse(hn::Lt(most, root), most, root);
      const uint32_t ends = bits_of(hn::Ge(chance, survival)) & onward;
      state_.counters.roulette_ends += static_cast<uint64_t>(std::popcount(ends));
      onward &= ~ends;
      throughput = multiply(throughput, hn::Div(all(1), survival));
    }
    note_direction(bundle, onward);
    Lanes3 wi;
    Lanes density;
    onward &= bits_of(scatter.sample(bundle.way_on, wi, density));
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
      const uint32_t place = bundle.places[take_lowest_lane(onward)];
      next_->path_length[rays.count] = now_->path_length[place];
      next_->number[rays.count++] = now_->number[place];
    }
  }

  const Scene& scene_;
  std::span<Color> found_;
  TraceState& state_;
  PathFront fronts_[2];
  PathFront *now_ = &fronts_[0], *next_ = &fronts_[1];
  Unmade<Hit, PathRows::kMost> hits_;
  Unmade<SampleStream, PathRows::kMost> streams_;
  uint32_t depth_ = 0;
};

PathRows::Code path_row_code() {
  return [](const Scene& scene, std::span<const Ray> rays, std::span<const SampleKey> keys,
            std::span<Color> found, TraceState& state)
             HWY_ATTR { PathRowFollower(scene, found, state).follow(rays, keys); };
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

bool PathRows::can_follow(const Scene& scene) {
  return scene.features.lambert && !scene.features.secondary && scene.surfaces &&
         scene.fog.kind == FogKind::none;
}

PathRows::PathRows(const Scene& scene, std::string_view instructions)
    : scene_(scene),
      code_(code_of_target(TESSERA_EACH_TARGET(path_row_code), instructions)()) {}

void PathRows::radiances(std::span<const Ray> rays, std::span<const SampleKey> keys,
                         std::span<Color> found, TraceState& state) const {
  TESSERA_CHECK(rays.size() >= 1 && rays.size() <= kMost && keys.size() == rays.size() &&
                    found.size() == rays.size(),
                fmt::format("{} rays, {} keys, {} found", rays.size(), keys.size(), found.size()));
  const Ray &first = rays.front(), &last = rays.back();
  TESSERA_CHECK(first.t_min == last.t_min && first.t_max == last.t_max,
                fmt::format("from {} to {}, from {} to {}", first.t_min, first.t_max, last.t_min,
                            last.t_max));
  code_(scene_, rays, keys, found, state);
}

}  // namespace tessera
#endif  // HWY_ONCE
