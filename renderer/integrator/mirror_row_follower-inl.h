// Part of mirror_rows.cpp, compiled once for each instruction set: local_radiance() and ideal
// mirrors, a lane a ray.
#if defined(TESSERA_MIRROR_ROW_FOLLOWER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_MIRROR_ROW_FOLLOWER_INL_H
#undef TESSERA_MIRROR_ROW_FOLLOWER_INL_H
#else
#define TESSERA_MIRROR_ROW_FOLLOWER_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "renderer/accel/carved_lanes-inl.h"
#include "renderer/accel/few_rows.h"
#include "renderer/accel/slab_lanes-inl.h"
#include "renderer/accel/sphere_lanes-inl.h"
#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/lane_light-inl.h"
#include "renderer/integrator/lane_row-inl.h"
#include "renderer/integrator/mirror_surfaces.h"
#include "renderer/integrator/row_follower-inl.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Some rays that hit one instance, a lane each. What fills the vector up is one of them again.
struct MirrorBundle {
  uint32_t places[kLanes];  ///< in the front
  uint32_t bits = 0;        ///< of lanes that are rays
  Lanes3 direction;
  Lanes3 origin;
  Lanes t, path_length;  ///< the latter up to the hit
  Lanes3 throughput;
};

/// Follows rays from mirror to mirror, and ends them at all else.
class MirrorRowFollower : public RowFollower<RayFront> {
 public:
  using Surfaces = MirrorSurfaces;
  MirrorRowFollower(const Surfaces& surfaces, std::span<Color> found, TraceState& state)
      : RowFollower(surfaces.scene(), found, state), surfaces_(surfaces) {}

  /// The camera's rays, which draw no numbers.
  void follow(std::span<const SampleKey>) {
    follow_all([this] HWY_ATTR { step(); });
  }

 private:
  /// Up to the next hits, and what is seen there.
  void step() {
    find_hits();
    // Room for what fills a vector up.
    uint32_t left[RayRow::kMost], missed[RayRow::kMost + kLanes], same[RayRow::kMost + kLanes];
    size_t n = 0, misses = 0;
    for (uint32_t i = 0; i < now_->rays.count; ++i) {
      left[n] = missed[misses] = i;
      n += is_hit(i);
      misses += !is_hit(i);
    }
    bring_background(missed, misses);
    while (n > 0) {
      const uint32_t instance = hits_[left[0]].instance;
      const size_t count = take_instance(left, n, same);
      for (size_t i = 0; i < count; i += kLanes)
        shade(same + i, std::min(kLanes, count - i), instance);
    }
  }

  void bring(uint32_t place, const Color& seen) {
    Color& sum = sum_of(place);
    sum = sum + seen;
  }
  /// To rays that meet nothing; there is room behind `places`.
  void bring_background(uint32_t* places, size_t count) {
    look_beyond(places, count, [&](uint32_t place, const Color& seen, const Vec2*) {
      bring(place, throughput(place) * seen);
    });
  }
  void shade(const uint32_t* places, size_t count, uint32_t instance) {
    MirrorBundle bundle;
    std::copy_n(places, kLanes, bundle.places);
    bundle.bits = (1u << count) - 1;
    const LaneIndices at = indices_of(places);
    bundle.origin = gather(now_->rays.origin, at);
    bundle.direction = gather(now_->rays.direction, at);
    bundle.t = gather_hits<&Hit::t>(hits_.data(), at);
    bundle.throughput = gather(now_->throughput, at);
    bundle.path_length = hn::Add(gather(now_->path_length, at), bundle.t);
    const Lanes3 at_hit = add(bundle.origin, multiply(bundle.direction, bundle.t));
    const Surfaces::Placed& placed = surfaces_.placed(instance);
    const Shape& shape = *scene_.instances[instance].shape;
    if (placed.form == Surfaces::Form::plane) {
      shade(bundle, surface_of(static_cast<const Plane&>(shape), placed.normal, at_hit), instance,
            0);
    } else if (placed.form == Surfaces::Form::sphere) {
      shade(bundle, surface_of(static_cast<const Sphere&>(shape), placed.facing, at_hit), instance,
            0);
    } else {
      shade_one_by_one(bundle, instance);
    }
  }

  // ----------------------------------------------------------------------------------- surfaces

  /// Where the surfaces have to be asked for one at a time; they may be of several materials.
  void shade_one_by_one(MirrorBundle& bundle, uint32_t instance) {
    Stored3 point, error, front, shading;
    uint32_t materials[kLanes], unusual = 0;
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const uint32_t place = bundle.places[lane];
      if (lane > 0 && place == bundle.places[0]) {
        point.put(lane, point.vec(0)), error.put(lane, error.vec(0));
        front.put(lane, front.vec(0)), shading.put(lane, shading.vec(0));
        continue;
      }
      const SurfaceInteraction s =
          surface_at(scene_.instances, now_->rays.ray(place), hits_[place]);
      if (s.smooth_shift != Vec3{} || s.has_vertex_color) unusual |= 1u << lane;
      point.put(lane, s.point - Point3{}), error.put(lane, s.point_error);
      front.put(lane, static_cast<Vec3>(s.geometric_normal));
      shading.put(lane, static_cast<Vec3>(s.shading_normal));
      materials[lane] = s.material;
    }
    const LaneSurface surface{point.load(), error.load(), front.load(), shading.load()};
    leave_alone(bundle, unusual & bundle.bits);
    for (uint32_t left = bundle.bits; left != 0;) {
      const uint32_t material = materials[std::countr_zero(left)];
      uint32_t same = 0;
      for (uint32_t bits = left; bits != 0;) {
        const size_t lane = take_lowest_lane(bits);
        if (materials[lane] == material) same |= 1u << lane;
      }
      bundle.bits = same;
      shade(bundle, surface, instance, material);
      left &= ~same;
    }
  }

  // -------------------------------------------------------------------------------------- light

  /// What shading knows of the surface, seen from where the rays came.
  struct Seen {
    const LaneSurface& surface;
    const Material& material;
    Lanes3 geometric_normal, normal;
  };

  void shade(MirrorBundle bundle, const LaneSurface& surface, uint32_t instance, uint32_t slot) {
    const Material& material = scene_.material(instance, slot);
    const auto is_back = hn::Gt(dot(surface.front, bundle.direction), hn::Zero(kLaneTag));
    // Such surfaces are met from behind by the last digit alone.
    if (material.sides == Sides::front_only) leave_alone(bundle, bits_of(is_back) & bundle.bits);
    if (bundle.bits == 0) return;
    const Seen seen{surface, material, choose(is_back, negate(surface.front), surface.front),
                    choose(is_back, negate(surface.shading), surface.shading)};
    state_.counters.hits += static_cast<uint64_t>(std::popcount(bundle.bits));
    const Lanes3 result = multiply(
        bundle.throughput, local_radiance(seen, surfaces_.placed(instance).light_set, bundle));
    if (material.is_mirror()) {
      go_on(bundle, seen, result);
    } else {
      bring(bundle.places, bundle.bits, Stored3(result));
    }
  }
  void bring(const uint32_t* places, uint32_t bits, const Stored3& results) {
    while (bits != 0) {
      const size_t lane = take_lowest_lane(bits);
      bring(places[lane], results.color(lane));
    }
  }

  /// Leaves the paths of those lanes to be followed one by one.
  void leave_alone(MirrorBundle& bundle, uint32_t bits) {
    bundle.bits &= ~bits;
    while (bits != 0) {
      const uint32_t place = bundle.places[take_lowest_lane(bits)];
      Color& sum = sum_of(place);
      sum = surfaces_.alone().follow_to_end(
          {now_->rays.ray(place), sum, throughput(place), now_->path_length[place], vertex_},
          state_);
    }
  }

  /// tessera::local_radiance() of simple features.
  Lanes3 local_radiance(const Seen& seen, uint32_t light_set, const MirrorBundle& bundle) {
    const Material& material = seen.material;
    Lanes3 result = all(material.emission);
    uint32_t answered = 0;
    if (has_shadows() && scene_.occluders.few) answered = answered_by_buffers(seen.surface);
    const LightReach& reach = scene_.global_lights;
    if (reach.is_everywhere()) {
      add_lights(seen, light_set, reach.all(), answered, bundle, result);
    } else {
      add_lights_in_reach(seen, light_set, answered, bundle, result);
    }
    const Color& part = material.ambient_times_diffuse ? material.diffuse : kWhite;
    return add(result, all(surfaces_.ambient(light_set) * material.ambient * part));
  }
  /// Points that have one list of lights together.
  void add_lights_in_reach(const Seen& seen, uint32_t light_set, uint32_t answered,
                           MirrorBundle bundle, Lanes3& result) {
    const LightReach& reach = scene_.global_lights;
    const Stored3 points(seen.surface.point);
    std::span<const uint32_t> lists[kLanes];
    for (size_t lane = 0; lane < kLanes; ++lane) lists[lane] = reach.at(points.point(lane));
    for (uint32_t left = bundle.bits; left != 0; left &= ~bundle.bits) {
      const std::span<const uint32_t> lights = lists[std::countr_zero(left)];
      bundle.bits = 0;
      for (uint32_t bits = left; bits != 0;) {
        const size_t lane = take_lowest_lane(bits);
        const bool is_same =
            lists[lane].data() == lights.data() && lists[lane].size() == lights.size();
        bundle.bits |= uint32_t{is_same} << lane;
      }
      state_.counters.lights_culled +=
          static_cast<uint64_t>(std::popcount(bundle.bits)) * (reach.all().size() - lights.size());
      add_lights(seen, light_set, lights, answered, bundle, result);
    }
  }
  /// Of `globals` and the scope, in the lanes of the bundle.
  void add_lights(const Seen& seen, uint32_t light_set, std::span<const uint32_t> globals,
                  uint32_t answered, const MirrorBundle& bundle, Lanes3& result) {
    const Material& material = seen.material;
    Scene::for_each_light(globals, scene_.scoped_lights[light_set], [&](uint32_t index) HWY_ATTR {
      const Light& light = scene_.lights[index];
      Arriving sampled;
      const uint32_t reached = sample(light, seen.surface.point, bundle.path_length, sampled);
      uint32_t lit = bundle.bits & reached;
      const Lanes zero = hn::Zero(kLaneTag);
      if (has_shadows() && material.diffuse_model == DiffuseModel::signed_lambert) {
        lit &= ~bits_of(hn::Lt(dot(seen.geometric_normal, sampled.wi), zero));
      }
      Lanes3 arriving = multiply(all(light.intensity), sampled.factor);
      const Lanes3 share =
          reflected_share(seen, material.diffuse, sampled.wi, bundle.direction, lit);
      lit &= ~bits_of(hn::Or(is_black(arriving), is_black(share)));
      state_.counters.shadow_rays_skipped +=
          static_cast<uint64_t>(std::popcount(bundle.bits & ~lit));
      if (lit == 0) return;
      if (has_shadows()) {
        const uint32_t shaded = shaded_of(seen.surface, index, sampled, lit, answered);
        if (shaded != 0)
          arriving = multiply(arriving, hn::IfThenElse(mask_of(shaded), zero, all(1)));
      }
      result = choose(mask_of(lit), add(result, multiply(arriving, share)), result);
    });
  }
  bool has_shadows() const { return scene_.features.shadows; }

  /// tessera::reflected_share(); right in the lanes of `bits`.
  static Lanes3 reflected_share(const Seen& seen, const Color& diffuse, const Lanes3& wi,
                                const Lanes3& direction, uint32_t bits) {
    const Material& material = seen.material;
    const Lanes n_dot_l = dot(seen.normal, wi), zero = hn::Zero(kLaneTag);
    Lanes factor = n_dot_l;
    if (material.diffuse_model == DiffuseModel::lambert) {
      factor = greater(n_dot_l, zero);
    } else if (material.diffuse_model == DiffuseModel::half_lambert) {
      alignas(64) double cosines[kLanes];
      hn::Store(n_dot_l, kLaneTag, cosines);
      for (uint32_t left = bits; left != 0;) {
        const size_t lane = take_lowest_lane(left);
        cosines[lane] = half_lambert(cosines[lane], material.diffuse_exponent);
      }
      factor = hn::Load(kLaneTag, cosines);
    }
    const Lanes3 share = multiply(all(diffuse), factor);
    if (tessera::is_black(material.specular)) return share;
    const Stored3 normals(seen.normal), lights(wi), ways(negate(direction));
    Stored3 shares(share);
    for (uint32_t left = bits & bits_of(hn::Gt(n_dot_l, zero)); left != 0;) {
      const size_t lane = take_lowest_lane(left);
      Color sum = shares.color(lane);
      sum += highlight(material, normals.vec(lane), lights.vec(lane), ways.vec(lane));
      shares.put(lane, {sum.r, sum.g, sum.b});
    }
    return shares.load();
  }

  // ------------------------------------------------------------------------------------ shadows

  /// LightBuffer::has_answers().
  uint32_t answered_by_buffers(const LaneSurface& s) const {
    const Lanes reach =
        hn::Add(sum(abs(s.point)), hn::Mul(all(LightBuffer::kErrorShare), sum(abs(s.error))));
    return bits_of(hn::Le(reach, all(scene_.occluders.few->boxes().farthest)));
  }

  /// Of `bits`, those whose shadow rays hit what one of their boxes holds, where that can be told
  /// of many at once. From the others it takes away those boxes, and all that they do not enter.
  uint32_t shaded_at_once(const Lanes3& origin, const Lanes3& way, Lanes last, uint32_t bits,
                          uint32_t* boxes) const {
    const FewInstances& few = *scene_.occluders.few;
    const FewRows& rows = few.rows();
    const SlabLanes slabs(origin, way);
    bits &= bits_of(slabs.are_usual(few.boxes()));
    uint32_t some = 0, shaded = 0;
    for (uint32_t left = bits; left != 0;) some |= boxes[take_lowest_lane(left)];
    for (uint32_t left = some & few.boxes().all; left != 0;) {
      const size_t box = take_lowest_lane(left);
      const uint32_t bit = 1u << box;
      const Lanes first = hn::Zero(kLaneTag);
      Lanes enter = first, t = first;
      uint32_t in = bits_of(slabs.entered(few.boxes(), box, enter, last)) & bits;
      if (((rows.spheres.boxes | rows.carved_boxes) & bit) != 0 && in != 0) {
        state_.counters.traversal.primitive_tests += static_cast<uint64_t>(std::popcount(in));
        uint32_t in_doubt = 0;
        if ((rows.carved_boxes & bit) != 0) {
          const CarvedBoxMet met = meet_carved_box(rows.carved[box], origin, way, last);
          shaded |= in & bits_of(met.hit);
          in_doubt = in & ~bits_of(hn::Or(met.hit, met.missed));
        } else if ((rows.spheres.shading & bit) != 0) {
          shaded |= in & bits_of(meet_sphere(rows.spheres, box, origin, way, first, last, t));
        }
        in = in_doubt;
      }
      for (uint32_t out = bits & ~in; out != 0;) boxes[take_lowest_lane(out)] &= ~bit;
    }
    return shaded;
  }

  /// Of the points `lit`, those that the light does not reach for what is in the way.
  uint32_t shaded_of(const LaneSurface& s, uint32_t index, const Arriving& sampled, uint32_t lit,
                     uint32_t answered) {
    const Occluders& occluders = scene_.occluders;
    state_.counters.rays_shadow += static_cast<uint64_t>(std::popcount(lit));
    uint32_t boxes[kLanes] = {};
    uint32_t asked = lit & ~answered;
    if ((lit & answered) != 0) {
      look_up(occluders.buffers[index], s, sampled, lit & answered, boxes);
      for (uint32_t left = lit & answered; left != 0;) {
        const size_t lane = take_lowest_lane(left);
        asked |= uint32_t{occluders.few->holds_any(boxes[lane])} << lane;
      }
    }
    if (asked == 0) return 0;
    const Light& light = scene_.lights[index];
    const bool placed = light.kind == LightKind::point;
    const Lanes3 place = all(light.position);
    const Lanes3 origins = origin_towards(s, placed ? subtract(place, s.point) : sampled.wi);
    const Lanes3 ways = placed ? subtract(place, origins) : sampled.wi;
    Lanes last = placed ? all(1) : sampled.distance;
    if (std::isfinite(light.shadow_distance)) {
      const Lanes whole = placed ? sampled.distance : all(1);
      const Lanes there = hn::Div(all(light.shadow_distance), whole);
      last = hn::IfThenElse(hn::Lt(there, last), there, last);
    }
    uint32_t shaded = 0;
    if ((asked & answered) != 0) {
      shaded = shaded_at_once(origins, ways, last, asked & answered, boxes);
      asked &= ~shaded;
      for (uint32_t left = asked & answered; left != 0;) {
        const size_t lane = take_lowest_lane(left);
        if (!occluders.few->holds_any(boxes[lane])) asked &= ~(1u << lane);
      }
    }
    if (asked == 0) return shaded;
    const Stored3 origin(origins), way(ways);
    alignas(64) double t_max[kLanes];
    hn::Store(last, kLaneTag, t_max);
    while (asked != 0) {
      const size_t lane = take_lowest_lane(asked);
      const Ray ray{origin.point(lane), way.vec(lane), 0, t_max[lane]};
      const bool stops =
          (answered >> lane & 1) != 0
              ? occluders.few->any_hit_among(boxes[lane], ray, state_.counters.traversal)
              : is_stopped(scene_, light, ray, state_);
      shaded |= uint32_t{stops} << lane;
    }
    return shaded;
  }

  // ------------------------------------------------------------------------------------ mirrors

  /// Adds `result` and sends the rays on.
  void go_on(const MirrorBundle& bundle, const Seen& seen, const Lanes3& result) {
    const Lanes zero = hn::Zero(kLaneTag);
    const Lanes3& d = bundle.direction;
    const auto by_shading = hn::Lt(dot(seen.normal, d), zero);
    Lanes3 way = reflect(d, choose(by_shading, seen.normal, seen.geometric_normal));
    const auto into = hn::Le(dot(way, seen.geometric_normal), zero);
    way = normalize(choose(into, reflect(d, seen.geometric_normal), way));
    const Lanes3 weight = multiply(bundle.throughput, all(seen.material.reflectivity));
    const Lanes most = greater(weight.x, greater(weight.y, weight.z));
    uint32_t onward = bundle.bits;
    if (scene_.skips.faint_branches) {
      const uint32_t faint = bits_of(hn::Lt(most, all(kFaintest))) & bundle.bits;
      state_.counters.branches_skipped += static_cast<uint64_t>(std::popcount(faint));
      onward &= ~faint;
    }
    const Stored3 results(result);
    const bool ends = vertex_ >= scene_.settings.max_depth;
    const bool sees_beyond = scene_.settings.background_at_max_depth;
    if (ends && !sees_beyond) onward = 0;
    if (!ends) state_.counters.rays_reflection += static_cast<uint64_t>(std::popcount(onward));
    bring(bundle.places, ends ? bundle.bits & ~onward : bundle.bits, results);
    if (onward == 0) return;
    const Lanes3 origin = origin_towards(seen.surface, way);
    if (ends) {
      const Stored3 origins(origin), ways(way), weights(weight);
      while (onward != 0) {
        const size_t lane = take_lowest_lane(onward);
        Color sum = results.color(lane);
        sum += weights.color(lane) * background({origins.point(lane), ways.vec(lane)});
        bring(bundle.places[lane], sum);
      }
      return;
    }
    RayRow& rays = next_->rays;
    append(origin, onward, rays.count, rays.origin);
    append(way, onward, rays.count, rays.direction);
    append(weight, onward, rays.count, next_->throughput);
    append(bundle.path_length, onward, next_->path_length + rays.count);
    while (onward != 0)
      next_->number[rays.count++] = now_->number[bundle.places[take_lowest_lane(onward)]];
  }

  const Surfaces& surfaces_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
