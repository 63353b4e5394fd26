#include "renderer/integrator/path_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/unmade.h"
#include "renderer/accel/mesh_shape.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/path_vertex.h"
#include "renderer/math/targets.h"
#include "renderer/shapes/csg_shape.h"

// This file is compiled once for each instruction set, as bvh_kernels.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/integrator/path_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/integrator/lane_camera-inl.h"
#include "renderer/integrator/lane_row-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/sampler/lane_sampler-inl.h"
#include "renderer/shading/lane_lambert-inl.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/lane_transform-inl.h"
#include "renderer/shapes/lane_triangle-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Paths that have met as many surfaces.
struct PathFront {
  RayRow rays;
  alignas(64) double throughput[3][RayRow::kRoom];
  alignas(64) double path_length[RayRow::kRoom];
  alignas(64) double radiance_scale[RayRow::kRoom];
  // Of the last bounce, where there was one.
  alignas(64) double density[RayRow::kRoom];
  alignas(64) double from[3][RayRow::kRoom], from_normal[3][RayRow::kRoom];
  uint32_t number[PathRows::kMost];  ///< of the path
};

/// What a front's paths meet, those of one instance side by side. All is worked out of all of them
/// before what depends on it: to read as a vector what was just written one by one makes the
/// processor wait.
struct Met {
  size_t count = 0;
  size_t even = 0;                           ///< the first so many surfaces scatter evenly
  uint32_t place[PathRows::kMost + kLanes];  ///< in the front
  LaneSurfaces<RayRow::kRoom> surface;
  alignas(64) double diffuse[3][RayRow::kRoom];
  uint32_t triangle[PathRows::kMost + kLanes];  ///< and other primitives
  uint8_t is_back[RayRow::kRoom / kLanes + 1];  ///< a bit for each lane
  // Numbers, and which pairs each path asked for, a bit each.
  alignas(64) double on_light[2][RayRow::kRoom], direction[2][RayRow::kRoom];
  alignas(64) double choice[2][RayRow::kRoom], pick[RayRow::kRoom];
  uint8_t read[RayRow::kRoom];
};

/// Of the paths that choose one, a point of an area light.
struct LightPoints {
  alignas(64) double point[3][RayRow::kRoom], error[3][RayRow::kRoom], normal[3][RayRow::kRoom];
  alignas(64) double front[3][RayRow::kRoom], back[3][RayRow::kRoom];
  alignas(64) double density[RayRow::kRoom];  ///< 0 where there is none
};

/// The stretches from surfaces to area lights, and what light they bring to each path.
struct ShadowRows {
  RayRow rays;
  alignas(64) double light[3][RayRow::kRoom];
  uint32_t number[PathRows::kMost];
};

/// power_heuristic()
HWY_INLINE Lanes power_heuristic(Lanes own, Lanes other) {
  const Lanes ratio = hn::Div(other, own);
  return hn::Div(all(1), hn::Add(all(1), hn::Mul(ratio, ratio)));
}

template <size_t kRoom>
Vec3 vec_at(const double (&parts)[3][kRoom], size_t at) {
  return {parts[0][at], parts[1][at], parts[2][at]};
}
template <size_t kRoom>
Color color_at(const double (&parts)[3][kRoom], size_t at) {
  return {parts[0][at], parts[1][at], parts[2][at]};
}
template <size_t kRoom>
void put(const Vec3& v, size_t at, double (&parts)[3][kRoom]) {
  for (int axis = 0; axis < 3; ++axis) parts[axis][at] = v[axis];
}
template <size_t kRoom>
void put(const Color& c, size_t at, double (&parts)[3][kRoom]) {
  parts[0][at] = c.r, parts[1][at] = c.g, parts[2][at] = c.b;
}

class PathRowFollower {
 public:
  PathRowFollower(const PathRows& rows, std::span<Color> found, TraceState& state)
      : rows_(rows), scene_(rows.scene()), found_(found), state_(state) {}

  void follow(std::span<const Ray> rays, std::span<const SampleKey> keys) {
    set_rays(rays, now_->rays);
    follow_all(keys);
  }
  /// Camera::ray() through each.
  void follow(const Camera::Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
              std::span<const SampleKey> keys) {
    set_rays(camera, rasters, now_->rays);
    follow_all(keys);
  }

 private:
  void follow_all(std::span<const SampleKey> keys) {
    for (size_t i = 0; i < keys.size(); ++i)
      streams_[i] = scene_.sampler->stream(keys[i].x, keys[i].y, keys[i].sample);
    if (scene_.features.rich) find_cones(keys);
    for (auto& channel : now_->throughput) std::fill_n(channel, keys.size(), 1.0);
    std::fill_n(now_->path_length, keys.size(), 0.0);
    std::fill_n(now_->radiance_scale, keys.size(), 1.0);
    std::fill_n(now_->density, keys.size(), 0.0);
    std::iota(now_->number, now_->number + keys.size(), 0u);
    std::ranges::fill(found_, kBlack);
    state_.counters.rays_primary += keys.size();
    for (; now_->rays.count > 0; ++depth_) {
      next_->rays.begin();
      step();
      std::swap(now_, next_);
    }
  }

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
      shadows_.rays.begin(0, 1);
      if (has_area_light()) choose_light_points();
      for (size_t at = 0; at < met_.even; at += kLanes) scatter(at);
      add_light_not_stopped();
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

  Color& sum_of(uint32_t place) { return found_[now_->number[place]]; }
  void add_background(uint32_t place) {
    const Ray ray = now_->rays.ray(place);
    sum_of(place) += color_at(now_->throughput, place) *
                     scene_.background.radiance(ray.origin, ray.direction, scene_.lights) *
                     background_weight(scene_, now_->density[place], ray.direction);
  }

  // ------------------------------------------------------------------------------------- surfaces

  void meet() {
    const size_t count = now_->rays.count;
    scene_.surfaces->closest_hits(now_->rays, {hits_.data(), count}, state_.counters.traversal);
    uint32_t left[PathRows::kMost];
    size_t n = 0;
    for (uint32_t i = 0; i < count; ++i) {
      left[n] = i;
      const bool is_hit = hits_[i].t < std::numeric_limits<double>::infinity();
      n += is_hit;
      if (!is_hit) add_background(i);
    }
    state_.counters.hits += n;
    met_.count = n;
    met_.even = 0;
    // Of those that scatter otherwise the instances, and where each one's places end.
    size_t uneven = 0, groups = 0;
    uint32_t instances[PathRows::kMost], ends[PathRows::kMost];
    while (n > 0) {
      const uint32_t instance = hits_[left[0]].instance;
      const size_t begin = met_.even;
      size_t end = begin, others = 0;
      for (size_t i = 0; i < n; ++i) {
        const uint32_t place = left[i];
        const bool is_it = hits_[place].instance == instance;
        met_.place[end] = left[others] = place;
        end += is_it;
        others += !is_it;
      }
      n = others;
      if (scene_.features.rich && !rows_.placed(instance).has_inputs)
        state_.counters.texture_points_skipped += end - begin;
      if (!rows_.placed(instance).is_even) {
        std::copy(met_.place + begin, met_.place + end, uneven_ + uneven);
        uneven += end - begin;
        instances[groups] = instance;
        ends[groups++] = static_cast<uint32_t>(uneven);
        continue;
      }
      std::fill_n(met_.place + end, kLanes, met_.place[begin]);
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
    const PathRows::Placed& placed = rows_.placed(instance);
    if (placed.form == PathRows::Form::other) {
      for (size_t i = begin; i < end; ++i) place_surface(i);
      return;
    }
    for (size_t i = begin; i < end; ++i) met_.triangle[i] = hits_[met_.place[i]].primitive;
    std::fill_n(met_.triangle + end, kLanes, met_.triangle[begin]);
    for (size_t i = begin; i < end; i += kLanes) {
      const LaneIndices at = hn::ShiftLeft<2>(indices_of(met_.place + i));
      const Lanes u = gather(&hits_[0].u, at), v = gather(&hits_[0].v, at);
      uint32_t bad = 0;
      if (placed.form == PathRows::Form::rectangle) {
        met_.surface.store(rectangle_surface(*placed.rectangle, placed.normal, u, v), i);
      } else {
        met_.surface.store(mesh_surface(placed, met_.triangle + i, u, v, bad), i);
      }
      for (bad &= (1u << std::min(kLanes, end - i)) - 1; bad != 0;)
        place_surface(i + take_lowest_lane(bad));
    }
  }
  static LaneSurface rectangle_surface(const Rectangle& rectangle, const Vec3& normal, Lanes u,
                                       Lanes v) {
    LaneSurface s = surface_of(rectangle, u, v);
    place_in_world(s.point, s.error);
    s.front = s.shading = all(normal);
    return s;
  }
  static LaneSurface mesh_surface(const PathRows::Placed& placed, const uint32_t* triangles,
                                  Lanes u, Lanes v, uint32_t& bad) {
    LaneSurface s = surface_of(*placed.mesh, triangles, u, v, bad);
    const Transform& to_world = placed.instance->world_from_object;
    const auto is_flat = hn::And(
        hn::Eq(s.front.x, s.shading.x),
        hn::And(hn::Eq(s.front.y, s.shading.y), hn::Eq(s.front.z, s.shading.z)));  // -0 is 0
    if (to_world.is_identity()) {
      place_in_world(s.point, s.error);
      s.front = unmoved_normal(s.front), s.shading = unmoved_normal(s.shading);
    } else {
      place_in_world(to_world, s.point, s.error);
      s.front = normal_in_world(to_world, s.front);
      s.shading = normal_in_world(to_world, s.shading);
    }
    s.shading = choose(is_flat, s.front, s.shading);
    if (placed.instance->flip_normals) s.front = negate(s.front), s.shading = negate(s.shading);
    const auto is_behind = hn::Lt(dot(s.front, s.shading), hn::Zero(kLaneTag));
    s.shading = choose(is_behind, negate(s.shading), s.shading);
    return s;
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
    return rows_.placed(instance).is_uniform && scene_.lights.empty();
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
      if (rows_.placed(point.surface.instance).has_inputs)
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
      const PathRows::Placed& placed = rows_.placed(hits_[place].instance);
      const bool is_back = (met_.is_back[i / kLanes] >> i % kLanes & 1) != 0;
      const PathRows::Side* const side = is_back ? placed.back : placed.front;
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
    sum_of(place) += color_at(now_->throughput, place) * shine *
                     emission_weight(scene_, point, now_->density[place], from,
                                     vec_at(now_->from_normal, place));
  }

  // -------------------------------------------------------------------------------------- numbers

  static constexpr uint8_t bit_of(VertexNumbers::Pair pair) {
    return static_cast<uint8_t>(1u << pair);
  }
  /// Beyond the camera's rays each path has drawn its next direction while that was traced.
  uint8_t ahead() const { return depth_ > 0 ? bit_of(VertexNumbers::kDirection) : uint8_t{0}; }
  bool has_area_light() const {
    return environment_share(scene_) > 0 || !scene_.area_lights.empty();
  }
  /// Whether a number chooses between lights.
  bool picks_light() const {
    const double to_sky = environment_share(scene_);
    return to_sky < 1 && (to_sky > 0 || scene_.area_lights.size() > 1);
  }
  bool may_end() const { return depth_ >= kSafeDepth; }

  void draw_numbers() {
    const bool on_light = has_area_light(), picks = on_light && picks_light();
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

  /// Of area lights, each path's point; light from the background is added at once.
  void choose_light_points() {
    const double to_sky = environment_share(scene_);
    const bool picks = picks_light();
    for (size_t i = 0; i < met_.even; ++i) {
      const double which = picks ? met_.pick[i] : 0;
      light_points_.density[i] = 0;
      if (which < to_sky) {
        read_on_light(i);
        continue;
      }
      choose_light_point(i, (which - to_sky) / (1 - to_sky), 1 - to_sky);
    }
    const size_t whole = (met_.even + kLanes - 1) / kLanes * kLanes;
    for (size_t i = met_.even; i < whole; ++i) light_points_.density[i] = 0;
    for (size_t i = 0; i < whole; ++i) {
      if (light_points_.density[i] > 0) continue;
      // Some place that is not the point's own.
      put(vec_at(met_.surface.point, i) + vec_at(met_.surface.front, i), i, light_points_.point);
      for (auto* const parts :
           {&light_points_.error, &light_points_.normal, &light_points_.front, &light_points_.back})
        put(Vec3{}, i, *parts);
    }
  }
  Vec2 read_on_light(size_t i) {
    met_.read[i] |= bit_of(VertexNumbers::kOnLight) | bit_of(VertexNumbers::kDirection);
    return {met_.on_light[0][i], met_.on_light[1][i]};
  }
  void choose_light_point(size_t i, double u, double share) {
    const AreaLights& lights = scene_.area_lights;
    const Point3 from = Point3{} + vec_at(met_.surface.point, i);
    const bool is_back = (met_.is_back[i / kLanes] >> i % kLanes & 1) != 0;
    const Vec3 front = vec_at(met_.surface.front, i);
    const LightTree::Pick pick = lights.tree().pick(from, is_back ? -front : front, u);
    const AreaLight& light = lights[pick.index];
    if (scene_.skips.dark_shadow_rays && light.is_dark_from(from)) {
      ++state_.counters.shadow_rays_skipped;
      return;
    }
    SurfaceSample sample;
    const double density =
        light.sampler->sample(from, read_on_light(i), sample) * pick.probability * share;
    if (!(density > 0)) return;
    light_points_.density[i] = density;
    put(sample.point - Point3{}, i, light_points_.point);
    put(sample.point_error, i, light_points_.error);
    put(sample.normal, i, light_points_.normal);
    put(light.front, i, light_points_.front);
    put(light.back, i, light_points_.back);
  }

  /// Some paths where they are, a lane each. What fills the vector up is the front's first again.
  struct Bundle {
    size_t at;      ///< of the first
    uint32_t bits;  ///< of lanes that are paths
    LaneSurface surface;
    Lanes3 facet;  ///< the geometric normal, towards the viewer
    Lanes3 throughput;
  };

  void scatter(size_t at) {
    const LaneIndices places = indices_of(met_.place + at);
    Bundle bundle{at, (1u << std::min(kLanes, met_.even - at)) - 1, met_.surface.load(at), {}, {}};
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

  void add_direct_light(const Bundle& bundle, const LaneLambert& lambert) {
    // Without lights of other kinds all that is left to know is what stops it.
    const bool is_all = environment_share(scene_) == 0 && scene_.lights.empty();
    const Lanes zero = hn::Zero(kLaneTag);
    Lanes3 light{zero, zero, zero};
    if (has_area_light()) light = from_area_lights(bundle, lambert, is_all);
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
      if (to_sky > 0 && (!picks_light() || met_.pick[i] < to_sky))
        sum += vertex.from_environment(to_sky, {met_.on_light[0][i], met_.on_light[1][i]});
      vertex.add_lights(sum);
    });
    sum_of(place) += color_at(now_->throughput, place) * sum;
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

  /// Black if it may be added later, of those that nothing stops.
  Lanes3 from_area_lights(const Bundle& bundle, const LaneLambert& lambert, bool may_wait) {
    const Lanes zero = hn::Zero(kLaneTag);
    const Lanes3 none{zero, zero, zero};
    const size_t at = bundle.at;
    const Lanes density = hn::Load(kLaneTag, light_points_.density + at);
    const uint32_t chosen = bits_of(hn::Gt(density, zero)) & bundle.bits;
    if (chosen == 0) return none;
    const Lanes3 place = load(light_points_.point, at), normal = load(light_points_.normal, at);
    const LaneSurface& here = bundle.surface;
    const Lanes3 wi = normalize(subtract(place, here.point));
    const auto in_front = hn::Lt(dot(wi, normal), zero);
    const Lanes3 shine =
        choose(in_front, load(light_points_.front, at), load(light_points_.back, at));
    LaneValue value = lambert.evaluate(wi);
    const auto shines_not = is_black(shine);
    value.density = hn::IfThenZeroElse(shines_not, value.density);
    const auto is_dark = hn::Or(shines_not, is_black(value.share));
    uint32_t asked = chosen;
    if (scene_.skips.dark_shadow_rays) {
      asked &= ~bits_of(is_dark);
      state_.counters.shadow_rays_skipped += static_cast<uint64_t>(std::popcount(chosen & ~asked));
    }
    state_.counters.rays_shadow += static_cast<uint64_t>(std::popcount(asked));
    // As point_visibility() does: the stretch ends before the light's own surface.
    const Lanes3 back = subtract(here.point, place);
    const auto behind = hn::Lt(dot(back, normal), zero);
    const Lanes3 side = choose(behind, negate(normal), normal);
    const Lanes lift = hn::Add(dot(abs(side), load(light_points_.error, at)),
                               hn::Mul(all(kLiftRoundings), sum(abs(back))));
    const Lanes3 origin = origin_towards(here, negate(back));
    const Lanes3 stretch = subtract(add(place, multiply(side, lift)), origin);
    const Lanes weight = power_heuristic(density, value.density);
    const Lanes3 brought =
        choose(is_dark, none, multiply(multiply(shine, value.share), hn::Div(weight, density)));
    if (may_wait) {
      append_shadow_rays(bundle, asked, origin, stretch, multiply(bundle.throughput, brought));
      return none;
    }
    return choose(mask_of(asked & ~stopped(origin, stretch, asked)), brought, none);
  }
  /// Of stretches in the lanes of `asked` those that something stops.
  uint32_t stopped(const Lanes3& origin, const Lanes3& stretch, uint32_t asked) {
    const Accelerator* const opaque = scene_.path_occluders.opaque.get();
    const Stored3 origins(origin), stretches(stretch);
    uint32_t lanes = 0;
    for (uint32_t left = opaque ? asked : 0; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      const Ray ray{origins.point(lane), stretches.vec(lane), 0, 1};
      lanes |= uint32_t{opaque->any_hit(ray, state_.counters.traversal)} << lane;
    }
    return lanes;
  }
  void append_shadow_rays(const Bundle& bundle, uint32_t asked, const Lanes3& origin,
                          const Lanes3& stretch, const Lanes3& light) {
    RayRow& rays = shadows_.rays;
    append(origin, asked, rays.count, rays.origin);
    append(stretch, asked, rays.count, rays.direction);
    append(light, asked, rays.count, shadows_.light);
    while (asked != 0) {
      const uint32_t place = met_.place[bundle.at + take_lowest_lane(asked)];
      shadows_.number[rays.count++] = now_->number[place];
    }
  }
  void add_light_not_stopped() {
    const Accelerator* const opaque = scene_.path_occluders.opaque.get();
    const RayRow& rays = shadows_.rays;
    if (rays.count == 0) return;
    const uint64_t stopped = opaque ? opaque->any_hits(rays, state_.counters.traversal) : 0;
    for (uint32_t i = 0; i < rays.count; ++i)
      if ((stopped >> i & 1) == 0) found_[shadows_.number[i]] += color_at(shadows_.light, i);
  }

  // --------------------------------------------------------------------------------------- bounce

  void bounce(const Bundle& bundle, const LaneLambert& lambert) {
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
    Color throughput = color_at(now_->throughput, place);
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

  const PathRows& rows_;
  const Scene& scene_;
  std::span<Color> found_;
  TraceState& state_;
  PathFront fronts_[2];
  PathFront *now_ = &fronts_[0], *next_ = &fronts_[1];
  Met met_;
  LightPoints light_points_;
  ShadowRows shadows_;
  Unmade<Hit, PathRows::kMost> hits_;
  Unmade<SampleStream, PathRows::kMost> streams_;
  uint32_t uneven_[PathRows::kMost];
  Unmade<Camera::PixelCone, PathRows::kMost> cones_;  ///< of the paths, where something is rich
  const Media no_media_{};
  uint32_t depth_ = 0;
};

PathRows::Code path_row_code() {
  return {[](const PathRows& of, std::span<const Ray> rays, std::span<const SampleKey> keys,
             std::span<Color> found, TraceState& state)
              HWY_ATTR { PathRowFollower(of, found, state).follow(rays, keys); },
          [](const PathRows& of, const Camera::Pinhole& camera,
             std::span<const Sampler::RasterSample> rasters, std::span<const SampleKey> keys,
             std::span<Color> found, TraceState& state)
              HWY_ATTR { PathRowFollower(of, found, state).follow(camera, rasters, keys); }};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

namespace {

void check_sizes(size_t rays, size_t keys, size_t found) {
  TESSERA_CHECK(rays >= 1 && rays <= PathRows::kMost && keys == rays && found == rays,
                fmt::format("{} rays, {} keys, {} found", rays, keys, found));
}

/// Whether it scatters evenly wherever it is looked up. Beside other models a black surface is one
/// that does not scatter, to be counted as such.
bool is_even(const Scene& scene, const Material& material) {
  Material plain = material;
  plain.inputs = kNoMaterialInputs;
  if (!plain.is_lambert() || plain.model != MaterialModel::classic) return false;
  if (!scene.features.lambert && is_black(material.diffuse)) return false;
  if (material.inputs == kNoMaterialInputs) return true;
  using Target = MaterialInputs::Target;
  return std::ranges::all_of(scene.inputs[material.inputs].slots, [](const auto& slot) {
    return slot.target == Target::ambient || slot.target == Target::diffuse ||
           slot.target == Target::emission;
  });
}

}  // namespace

bool PathRows::can_follow(const Scene& scene) {
  const bool skips_textures = !scene.features.rich || scene.skips.texture_points;
  return scene.surfaces && !scene.features.veils && scene.fog.kind == FogKind::none &&
         scene.skips.absent_features && skips_textures &&
         std::ranges::all_of(scene.materials, [](const Material& material) {
           return is_black(material.absorption);
         });
}

PathRows::PathRows(const Scene& scene, std::string_view instructions)
    : scene_(scene), code_(code_of_target(TESSERA_EACH_TARGET(path_row_code), instructions)()) {
  for (const Material& material : scene.materials)
    sides_.push_back({material.diffuse, !is_black(material.emission)});
  for (uint32_t i = 0; i < scene.instances.size(); ++i) placed_.push_back(place(i));
}

PathRows::Placed PathRows::place(uint32_t number) const {
  const Instance& instance = scene_.instances[number];
  Placed placed;
  placed.instance = &instance;
  if (const auto* const mesh = dynamic_cast<const MeshShape*>(instance.shape.get())) {
    constexpr size_t kMostVertices = size_t{1} << 29;  // their parts are numbered by 31 bits
    placed.mesh = &mesh->mesh();
    if (placed.mesh->positions.size() <= kMostVertices) placed.form = Form::mesh;
  }
  const auto* const rectangle = dynamic_cast<const Rectangle*>(instance.shape.get());
  if (rectangle && instance.world_from_object.is_identity()) {
    placed.form = Form::rectangle;
    placed.rectangle = rectangle;
    SurfaceInteraction surface = rectangle->surface({}, {});
    take_to_world(instance.world_from_object, instance.flip_normals, number, surface);
    placed.normal = static_cast<Vec3>(surface.geometric_normal);
  }
  find_sides(number, placed);
  return placed;
}

void PathRows::find_sides(uint32_t number, Placed& placed) const {
  const InstanceShading& shading = scene_.shading[number];
  const auto back_of = [&](const Material& material) -> const Material& {
    return material.sides == Sides::two_sided ? material : scene_.materials[material.back];
  };
  placed.is_even = true;
  for (uint32_t i = 0; i < shading.material_count; ++i) {
    const Material& material = scene_.material(number, i);
    for (const Material* const side : {&material, &back_of(material)}) {
      placed.is_even &= is_even(scene_, *side);
      placed.has_inputs |= side->inputs != kNoMaterialInputs;
    }
  }
  // Solids made of others may have any that theirs have.
  const bool has_colors = (placed.mesh && !placed.mesh->colors.empty()) ||
                          dynamic_cast<const CsgShape*>(placed.instance->shape.get()) != nullptr;
  placed.is_uniform = shading.material_count == 1 && !has_colors && !placed.has_inputs;
  if (!placed.is_uniform) return;
  const Material& front = scene_.material(number, 0);
  const Material& back = back_of(front);
  if (!front.flat) placed.front = &sides_[static_cast<size_t>(&front - scene_.materials.data())];
  if (!back.flat) placed.back = &sides_[static_cast<size_t>(&back - scene_.materials.data())];
}

void PathRows::radiances(std::span<const Ray> rays, std::span<const SampleKey> keys,
                         std::span<Color> found, TraceState& state) const {
  check_sizes(rays.size(), keys.size(), found.size());
  const Ray &first = rays.front(), &last = rays.back();
  TESSERA_CHECK(first.t_min == last.t_min && first.t_max == last.t_max,
                fmt::format("from {} to {}, from {} to {}", first.t_min, first.t_max, last.t_min,
                            last.t_max));
  code_.follow_rays(*this, rays, keys, found, state);
}

void PathRows::radiances(const Camera::Pinhole& camera,
                         std::span<const Sampler::RasterSample> rasters,
                         std::span<const SampleKey> keys, std::span<Color> found,
                         TraceState& state) const {
  check_sizes(rasters.size(), keys.size(), found.size());
  code_.follow_rasters(*this, camera, rasters, keys, found, state);
}

}  // namespace tessera
#endif  // HWY_ONCE
