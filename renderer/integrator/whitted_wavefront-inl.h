// Part of whitted_batches.cpp, compiled once for each instruction set: Whitted's rays, whose hits
// of simple materials are looked at a lane a ray, the others by whitted_hit().
#if defined(TESSERA_WHITTED_WAVEFRONT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_WHITTED_WAVEFRONT_INL_H
#undef TESSERA_WHITTED_WAVEFRONT_INL_H
#else
#define TESSERA_WHITTED_WAVEFRONT_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "renderer/accel/carved_lanes-inl.h"
#include "renderer/accel/instance_soa.h"
#include "renderer/accel/slab_lanes-inl.h"
#include "renderer/accel/sphere_lanes-inl.h"
#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/lane_batch-inl.h"
#include "renderer/integrator/light_lanes-inl.h"
#include "renderer/integrator/wavefront-inl.h"
#include "renderer/integrator/whitted_segments-inl.h"
#include "renderer/integrator/whitted_surfaces.h"
#include "renderer/math/lanes-inl.h"
#include "renderer/shading/clamped_normal.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// Follows what each camera ray brings segment by segment, in the order in which it would be
/// followed alone, whatever the others meet.
class WhittedWavefront : public Wavefront<WhittedRays> {
 public:
  using Surfaces = WhittedSurfaces;
  WhittedWavefront(const Surfaces& surfaces, std::span<Color> found, TraceState& state)
      : Wavefront(surfaces.scene(), found, state), surfaces_(surfaces) {}

  /// The camera's rays.
  void follow(std::span<const SampleKey> keys) {
    keys_ = keys;
    find_cones(keys);
    std::fill_n(now_->depth, keys.size(), 0u);
    if (!surfaces_.are_simple()) {
      std::fill_n(now_->passes, keys.size(), 0u);
      std::fill_n(now_->view_distance, keys.size(), 0.0);
      std::fill_n(now_->media, keys.size(), surfaces_.at_camera());
      waiting_.begin(keys.size());
    }
    follow_all([this] HWY_ATTR { step(); });
  }

 private:
  using Bundles = std::span<HitBundle>;

  /// Up to the next hits, and what is seen there.
  void step() {
    find_hits();
    sent_on_ = 0;
    // With space for what fills a vector up.
    uint32_t left[RayBatch::kMost], missed[RayBatch::kMost + kLanes],
        same[RayBatch::kMost + kLanes];
    size_t n = 0, misses = 0;
    for (uint32_t i = 0; i < now_->rays.count; ++i) {
      left[n] = missed[misses] = i;
      n += is_hit(i);
      misses += !is_hit(i);
    }
    bring_background(missed, misses);
    // Together where their shadow rays are faster together.
    const size_t together = surfaces_.batches_shadows() ? RayBatch::kMost : kLanes;
    while (n > 0) {
      const uint32_t instance = hits_[left[0]].instance;
      const size_t count = take_simple(instance, same, take_instance(left, n, same));
      for (size_t i = 0; i < count; i += together)
        shade(same + i, std::min(together, count - i), instance);
    }
    if (!surfaces_.are_simple()) go_on_with_waiting();
  }

  // ---------------------------------------------------------------------------- one by one

  /// Looks at those of the places, all of hits of the instance, that vectors are not for; returns
  /// how many are left, whose last vector is filled up again.
  size_t take_simple(uint32_t instance, uint32_t* places, size_t count) {
    const bool is_simple = surfaces_.placed(instance).is_simple;
    if (is_simple && surfaces_.are_simple()) return count;
    size_t n = 0;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t place = places[i];
      if (is_simple && tessera::is_black(now_->media[place].absorption()))
        places[n++] = place;
      else
        look_alone(place);
    }
    std::fill_n(places + n, kLanes, places[0]);
    return n;
  }
  void look_alone(uint32_t place) {
    const uint32_t number = now_->number[place];
    PathSegment segment{.ray = now_->rays.ray(place),
                        .throughput = throughput(place),
                        .media = {},
                        .path_length = now_->path_length[place],
                        .depth = now_->depth[place]};
    if (!surfaces_.are_simple()) {
      segment.media = now_->media[place];
      segment.view_distance = now_->view_distance[place];
      segment.passes = now_->passes[place];
    }
    if (scene_.features.rich) state_.cone = cones_[number];
    Branches branches;
    bring(place, surfaces_.look(segment, hits_[place], keys_[number], branches, state_));
    for (const PathSegment& branch : branches.all()) waiting_.put_aside(branch, number);
  }
  /// Each camera ray whose segment sends none on by itself goes on with what waits last.
  void go_on_with_waiting() {
    for (uint32_t place = 0; place < now_->rays.count; ++place) {
      const uint32_t number = now_->number[place];
      if ((sent_on_ >> place & 1) != 0 || !waiting_.any(number)) continue;
      if (waiting_.is_cut(number))
        ++state_.counters.paths_cut;
      else
        send(waiting_.take(number), number);
    }
  }
  void send(const PathSegment& segment, uint32_t number) {
    RayBatch& rays = next_->rays;
    const size_t at = rays.count++;
    put(segment.ray.origin - Point3{}, at, rays.origin);
    put(segment.ray.direction, at, rays.direction);
    rays.t_max[at] = segment.ray.t_max;
    put(segment.throughput, at, next_->throughput);
    next_->path_length[at] = segment.path_length;
    next_->number[at] = number;
    next_->depth[at] = segment.depth;
    next_->passes[at] = segment.passes;
    next_->view_distance[at] = segment.view_distance;
    next_->media[at] = segment.media;
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
    size_t n = 0;
    for (size_t i = 0; i < count; i += kLanes)
      meet(places + i, std::min(kLanes, count - i), instance, bundles_[n++]);
    const Bundles bundles{bundles_, n};
    if (surfaces_.placed(instance).form != Surfaces::Form::other) return shade(bundles, instance);
    // They may be of several materials.
    uint32_t left[kMostBundles];
    for (size_t i = 0; i < n; ++i) left[i] = bundles[i].bits;
    for (size_t first = 0; first < n;) {
      if (left[first] == 0) {
        ++first;
        continue;
      }
      const uint32_t material = bundles[first].materials[std::countr_zero(left[first])];
      for (size_t i = first; i < n; ++i) {
        bundles[i].bits = 0;
        for (uint32_t bits = left[i]; bits != 0;) {
          const size_t lane = take_lowest_lane(bits);
          if (bundles[i].materials[lane] == material) bundles[i].bits |= 1u << lane;
        }
        left[i] &= ~bundles[i].bits;
      }
      shade(bundles.subspan(first), instance, material);
    }
  }

  // ----------------------------------------------------------------------------------- surfaces

  void meet(const uint32_t* places, size_t count, uint32_t instance, HitBundle& bundle) {
    std::copy_n(places, kLanes, bundle.places);
    bundle.bits = (1u << count) - 1;
    const LaneIndices at = indices_of(places);
    bundle.direction = gather(now_->rays.direction, at);
    const Lanes t = gather_hits<&Hit::t>(hits_.data(), at);
    bundle.throughput = gather(now_->throughput, at);
    bundle.path_length = gather(now_->path_length, at) + t;
    const Surfaces::Placed& placed = surfaces_.placed(instance);
    const Shape& shape = *scene_.instances[instance].shape;
    if (placed.form == Surfaces::Form::other) return meet_one_by_one(bundle);
    const Lanes3 at_hit = gather(now_->rays.origin, at) + bundle.direction * t;
    bundle.surface = placed.form == Surfaces::Form::plane
                         ? surface_of(static_cast<const Plane&>(shape), placed.normal, at_hit)
                         : surface_of(static_cast<const Sphere&>(shape), placed.facing, at_hit);
    const Lanes zero = hn::Zero(kLaneTag);
    bundle.shift = {zero, zero, zero};
    bundle.tinted = 0;
  }
  /// Where the surfaces have to be asked for one at a time.
  void meet_one_by_one(HitBundle& bundle) {
    Stored3 point, error, front, shading, shift, tint;
    bundle.tinted = 0;
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const uint32_t place = bundle.places[lane];
      if (lane > 0 && (bundle.bits >> lane & 1) == 0) {
        for (Stored3* const each : {&point, &error, &front, &shading, &shift, &tint})
          each->put(lane, each->vec(0));
        bundle.materials[lane] = bundle.materials[0];
        bundle.tinted |= (bundle.tinted & 1) << lane;
        continue;
      }
      const SurfaceInteraction s =
          surface_at(scene_.instances, now_->rays.ray(place), hits_[place]);
      point.put(lane, s.point - Point3{}), error.put(lane, s.point_error);
      front.put(lane, static_cast<Vec3>(s.geometric_normal));
      shading.put(lane, static_cast<Vec3>(s.shading_normal));
      shift.put(lane, s.smooth_shift);
      tint.put(lane, {s.vertex_color.r, s.vertex_color.g, s.vertex_color.b});
      bundle.tinted |= uint32_t{s.has_vertex_color} << lane;
      bundle.materials[lane] = s.material;
    }
    bundle.surface = {point.load(), error.load(), front.load(), shading.load()};
    bundle.shift = shift.load(), bundle.tint = tint.load();
  }

  // -------------------------------------------------------------------------------------- light

  /// What is seen of one instance, in lanes of one material.
  void shade(Bundles bundles, uint32_t instance, uint32_t slot = 0) {
    const Material& material = scene_.material(instance, slot);
    for (HitBundle& bundle : bundles) look_at(bundle, material);
    see(bundles, material, surfaces_.placed(instance).light_set);
    for (HitBundle& bundle : bundles) {
      const Lanes3 result = bundle.throughput * bundle.seen;
      if (material.is_mirror()) {
        go_on(bundle, material, result);
      } else {
        bring(bundle.places, bundle.bits, Stored3(result));
      }
    }
  }
  void look_at(HitBundle& bundle, const Material& material) {
    const LaneSurface& surface = bundle.surface;
    const auto is_back = hn::Gt(dot(surface.front, bundle.direction), hn::Zero(kLaneTag));
    // Such surfaces are met from behind by the last digit alone.
    if (material.hides_back()) {
      uint32_t behind = movemask(is_back) & bundle.bits;
      bundle.bits &= ~behind;
      while (behind != 0) look_alone(bundle.places[take_lowest_lane(behind)]);
    }
    bundle.geometric_normal = select(is_back, -surface.front, surface.front);
    bundle.normal = select(is_back, -surface.shading, surface.shading);
    bundle.diffuse = broadcast(material.diffuse);
    if (bundle.tinted != 0) {
      const Lanes3 tinted =
          material.vertex_color_replaces_diffuse ? bundle.tint : bundle.diffuse * bundle.tint;
      bundle.diffuse = select(mask_of(bundle.tinted), tinted, bundle.diffuse);
    }
    const auto hits = static_cast<uint64_t>(std::popcount(bundle.bits));
    state_.counters.hits += hits;
    if (scene_.features.rich) state_.counters.texture_points_skipped += hits;
  }
  void bring(const uint32_t* places, uint32_t bits, const Stored3& results) {
    while (bits != 0) {
      const size_t lane = take_lowest_lane(bits);
      bring(places[lane], results.color(lane));
    }
  }

  /// local_radiance() of simple features.
  void see(Bundles bundles, const Material& material, uint32_t light_set) {
    for (HitBundle& bundle : bundles) bundle.seen = broadcast(material.emission);
    const LightGrid& reach = scene_.global_lights;
    if (reach.is_everywhere()) {
      add_lights(bundles, material, light_set, reach.all());
    } else {
      add_lights_in_reach(bundles, material, light_set);
    }
    const Color ambient = surfaces_.ambient(light_set) * material.ambient;
    for (HitBundle& bundle : bundles) {
      const Lanes3 part = material.ambient_times_diffuse ? bundle.diffuse : broadcast(kWhite);
      bundle.seen = bundle.seen + broadcast(ambient) * part;
    }
  }
  /// Points that have one list of lights together.
  void add_lights_in_reach(Bundles bundles, const Material& material, uint32_t light_set) {
    const LightGrid& reach = scene_.global_lights;
    std::span<const uint32_t> lists[kMostBundles][kLanes];
    uint32_t whole[kMostBundles], left[kMostBundles];
    for (size_t i = 0; i < bundles.size(); ++i) {
      whole[i] = left[i] = bundles[i].bits;
      const Stored3 points(bundles[i].surface.point);
      for (size_t lane = 0; lane < kLanes; ++lane) lists[i][lane] = reach.at(points.point(lane));
    }
    for (size_t first = 0; first < bundles.size();) {
      if (left[first] == 0) {
        ++first;
        continue;
      }
      const std::span<const uint32_t> lights = lists[first][std::countr_zero(left[first])];
      uint64_t points = 0;
      for (size_t i = 0; i < bundles.size(); ++i) {
        bundles[i].bits = 0;
        for (uint32_t bits = left[i]; bits != 0;) {
          const size_t lane = take_lowest_lane(bits);
          const auto& list = lists[i][lane];
          const bool is_same = list.data() == lights.data() && list.size() == lights.size();
          bundles[i].bits |= uint32_t{is_same} << lane;
        }
        left[i] &= ~bundles[i].bits;
        points += static_cast<uint64_t>(std::popcount(bundles[i].bits));
      }
      state_.counters.lights_culled += points * (reach.all().size() - lights.size());
      add_lights(bundles, material, light_set, lights);
    }
    for (size_t i = 0; i < bundles.size(); ++i) bundles[i].bits = whole[i];
  }
  /// Of `globals` and the scope, in the lanes of the bundles.
  void add_lights(Bundles bundles, const Material& material, uint32_t light_set,
                  std::span<const uint32_t> globals) {
    Scene::for_each_light(globals, scene_.scoped_lights[light_set], [&](uint32_t index) HWY_ATTR {
      ShadowRays rays(scene_.lights[index], index);
      for (size_t i = 0; i < bundles.size(); ++i) {
        LightSample sampled;
        if (light_up(bundles[i], material, rays.light, sampled) && has_shadows())
          ask_what_is_in_the_way(bundles[i], sampled, i, rays);
      }
      if (rays.batch.count > 0) trace(rays, bundles);
      for (HitBundle& bundle : bundles) {
        if (bundle.lit == 0) continue;
        if (bundle.shaded != 0) {
          const Lanes left =
              hn::IfThenElse(mask_of(bundle.shaded), hn::Zero(kLaneTag), broadcast(1));
          bundle.arriving = bundle.arriving * left;
        }
        const Lanes3 sum = bundle.seen + bundle.arriving * bundle.share;
        bundle.seen = select(mask_of(bundle.lit), sum, bundle.seen);
      }
    });
  }
  bool has_shadows() const { return scene_.features.shadows; }

  /// What the light brings to the points, but for what is in the way; whether it does to any.
  bool light_up(HitBundle& bundle, const Material& material, const Light& light,
                LightSample& sampled) {
    const uint32_t reached = sample(light, bundle.surface.point, bundle.path_length, sampled);
    bundle.lit = bundle.bits & reached;
    bundle.shaded = 0;
    if (has_shadows() && material.diffuse_model == DiffuseModel::signed_lambert) {
      const Lanes cosine = dot(bundle.geometric_normal, sampled.wi);
      bundle.lit &= ~movemask(hn::Lt(cosine, hn::Zero(kLaneTag)));
    }
    bundle.arriving = broadcast(light.intensity) * sampled.factor;
    bundle.share = reflected_share(bundle, material, sampled.wi);
    bundle.lit &= ~movemask(hn::Or(is_black(bundle.arriving), is_black(bundle.share)));
    state_.counters.shadow_rays_skipped +=
        static_cast<uint64_t>(std::popcount(bundle.bits & ~bundle.lit));
    return bundle.lit != 0;
  }

  /// tessera::reflected_share() in the lanes that are lit: in one go where it is by the cosine
  /// alone.
  static Lanes3 reflected_share(const HitBundle& bundle, const Material& material,
                                const Lanes3& wi) {
    if (material.diffuse_model != DiffuseModel::half_lambert &&
        tessera::is_black(material.specular)) {
      const Lanes n_dot_l = dot(bundle.normal, wi);
      const bool is_signed = material.diffuse_model != DiffuseModel::lambert;
      return bundle.diffuse * (is_signed ? n_dot_l : maximum(n_dot_l, num(0)));
    }
    const Stored3 diffuse(bundle.diffuse), normals(bundle.normal), lights(wi),
        ways(-bundle.direction);
    Stored3 shares(num_color(0));
    for (uint32_t left = bundle.lit; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      const Color share = tessera::reflected_share(material, diffuse.color(lane), normals.vec(lane),
                                                   lights.vec(lane), ways.vec(lane));
      shares.put(lane, {share.r, share.g, share.b});
    }
    return shares.load();
  }

  // ------------------------------------------------------------------------------------ shadows

  /// Those to one light that are to be traced together.
  struct ShadowRays {
    const Light& light;
    uint32_t index;
    RayBatch batch;
    uint8_t bundle[RayBatch::kMost], lane[RayBatch::kMost];

    ShadowRays(const Light& of, uint32_t number) : light(of), index(number) { batch.begin(); }
  };

  /// LightBuffer::has_answers().
  uint32_t answered_by_buffers(const HitBundle& bundle) const {
    if (!scene_.occluders.few) return 0;
    const LaneSurface& s = bundle.surface;
    const Lanes off = sum(s.error + abs(bundle.shift));
    const Lanes reach = sum(abs(s.point)) + broadcast(LightBuffer::kErrorShare) * off;
    return movemask(hn::Le(reach, broadcast(scene_.occluders.few->boxes().farthest)));
  }

  /// Of `bits`, those whose shadow rays hit what one of their boxes holds, where that can be told
  /// of many at once. From the others it takes away those boxes, and all that they do not enter.
  uint32_t shaded_at_once(const Lanes3& origin, const Lanes3& way, Lanes last, uint32_t bits,
                          uint32_t* boxes) const {
    const FewInstances& few = *scene_.occluders.few;
    const InstanceSoA& soa = few.soa();
    const SlabLanes slabs(origin, way);
    bits &= movemask(slabs.are_usual(few.boxes()));
    uint32_t some = 0, shaded = 0;
    for (uint32_t left = bits; left != 0;) some |= boxes[take_lowest_lane(left)];
    for (uint32_t left = some & few.boxes().all; left != 0;) {
      const size_t box = take_lowest_lane(left);
      const uint32_t bit = 1u << box;
      const Lanes first = hn::Zero(kLaneTag);
      Lanes enter = first, t = first;
      uint32_t in = movemask(slabs.entered(few.boxes(), box, enter, last)) & bits;
      if (((soa.spheres.boxes | soa.carved_boxes) & bit) != 0 && in != 0) {
        state_.counters.traversal.primitive_tests += static_cast<uint64_t>(std::popcount(in));
        uint32_t in_doubt = 0;
        if ((soa.carved_boxes & bit) != 0) {
          const CarvedBoxMet met = meet_carved_box(soa.carved[box], origin, way, last);
          shaded |= in & movemask(met.hit);
          in_doubt = in & ~movemask(hn::Or(met.hit, met.missed));
        } else if ((soa.spheres.shading & bit) != 0) {
          shaded |= in & movemask(meet_sphere(soa.spheres, box, origin, way, first, last, t));
        }
        in = in_doubt;
      }
      for (uint32_t out = bits & ~in; out != 0;) boxes[take_lowest_lane(out)] &= ~bit;
    }
    return shaded;
  }

  /// Finds the lit lanes that the light does not reach for what is in the way; rays that are to be
  /// traced with those of other bundles are added to `rays`.
  void ask_what_is_in_the_way(HitBundle& bundle, const LightSample& sampled, size_t number,
                              ShadowRays& rays) {
    const Occluders& occluders = scene_.occluders;
    const LaneSurface& s = bundle.surface;
    const uint32_t answered = answered_by_buffers(bundle) & bundle.lit;
    state_.counters.rays_shadow += static_cast<uint64_t>(std::popcount(bundle.lit));
    uint32_t boxes[kLanes] = {};
    uint32_t asked = bundle.lit & ~answered;
    if (answered != 0) {
      look_up(occluders.buffers[rays.index], s, sampled, answered, boxes);
      for (uint32_t left = answered; left != 0;) {
        const size_t lane = take_lowest_lane(left);
        asked |= uint32_t{occluders.few->holds_any(boxes[lane])} << lane;
      }
    }
    if (asked == 0) return;
    const Light& light = rays.light;
    const bool placed = rays.light.is_placed();
    const Lanes3 place = broadcast(light.position);
    const Lanes3 origins = shadow_origin(bundle, sampled.wi, placed ? place - s.point : sampled.wi);
    const Lanes3 ways = placed ? place - origins : sampled.wi;
    Lanes last = placed ? broadcast(1) : sampled.distance;
    if (std::isfinite(light.shadow_distance)) {
      const Lanes whole = placed ? sampled.distance : broadcast(1);
      const Lanes there = broadcast(light.shadow_distance) / whole;
      last = hn::IfThenElse(hn::Lt(there, last), there, last);
    }
    if ((asked & answered) != 0) {
      bundle.shaded = shaded_at_once(origins, ways, last, asked & answered, boxes);
      asked &= ~bundle.shaded;
      for (uint32_t left = asked & answered; left != 0;) {
        const size_t lane = take_lowest_lane(left);
        if (!occluders.few->holds_any(boxes[lane])) asked &= ~(1u << lane);
      }
    }
    if (asked == 0) return;
    if (surfaces_.batches_shadows()) {
      append(last, asked, rays.batch.t_max + rays.batch.count);
      append(origins, asked, rays.batch.count, rays.batch.origin);
      append(ways, asked, rays.batch.count, rays.batch.direction);
      while (asked != 0) {
        rays.bundle[rays.batch.count] = static_cast<uint8_t>(number);
        rays.lane[rays.batch.count++] = static_cast<uint8_t>(take_lowest_lane(asked));
      }
      return;
    }
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
      bundle.shaded |= uint32_t{stops} << lane;
    }
  }
  void trace(const ShadowRays& rays, Bundles bundles) {
    const Accelerator& opaque = *scene_.occluders.opaque;
    for (uint64_t hit = opaque.any_hits(rays.batch, state_.counters.traversal); hit != 0;
         hit &= hit - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(hit));
      bundles[rays.bundle[i]].shaded |= 1u << rays.lane[i];
    }
  }

  // ------------------------------------------------------------------------------------ mirrors

  /// Adds `result` and sends the rays on.
  void go_on(const HitBundle& bundle, const Material& material, const Lanes3& result) {
    const Lanes zero = hn::Zero(kLaneTag);
    const Lanes3& d = bundle.direction;
    const Lanes3 straight = reflect(d, bundle.normal);
    // As clamped_normal() asks.
    const Lanes half = dot(d, bundle.geometric_normal) * broadcast(-0.5);
    const Lanes least =
        hn::IfThenElse(hn::Lt(half, broadcast(kLeastMirrored)), half, broadcast(kLeastMirrored));
    const auto into = hn::Lt(dot(straight, bundle.geometric_normal), least);
    const uint32_t bent = movemask(hn::Or(into, hn::Gt(dot(bundle.normal, d), zero)));
    const Lanes3 way = bent_back(bundle, normalize(straight), bent & bundle.bits);
    const Lanes3 weight = bundle.throughput * broadcast(material.reflectivity);
    const Lanes most = maximum(weight.x, maximum(weight.y, weight.z));
    const uint32_t faint = movemask(hn::Lt(most, broadcast(kFaintest))) & bundle.bits;
    state_.counters.branches_skipped += static_cast<uint64_t>(std::popcount(faint));
    uint32_t onward = bundle.bits & ~faint, beyond = 0;  // what sees the background at most
    for (uint32_t left = onward; left != 0;) {
      const size_t lane = take_lowest_lane(left);
      beyond |= uint32_t{now_->depth[bundle.places[lane]] >= scene_.settings.max_depth} << lane;
    }
    onward &= ~beyond;
    if (!scene_.settings.background_at_max_depth) beyond = 0;
    state_.counters.rays_reflection += static_cast<uint64_t>(std::popcount(onward));
    const Stored3 results(result);
    bring(bundle.places, bundle.bits & ~beyond, results);
    if ((onward | beyond) == 0) return;
    const Lanes3 origin = origin_towards(bundle.surface, way);
    if (beyond != 0) {
      const Stored3 origins(origin), ways(way), weights(weight);
      while (beyond != 0) {
        const size_t lane = take_lowest_lane(beyond);
        Color sum = results.color(lane);
        sum += weights.color(lane) * background({origins.point(lane), ways.vec(lane)});
        bring(bundle.places[lane], sum);
      }
    }
    if (onward == 0) return;
    RayBatch& rays = next_->rays;
    append(origin, onward, rays.count, rays.origin);
    append(way, onward, rays.count, rays.direction);
    append(weight, onward, rays.count, next_->throughput);
    append(bundle.path_length, onward, next_->path_length + rays.count);
    while (onward != 0) carry(bundle.places[take_lowest_lane(onward)], rays.count++);
  }
  /// What a segment's reflection keeps of it.
  void carry(uint32_t place, size_t at) {
    next_->number[at] = now_->number[place];
    next_->depth[at] = now_->depth[place] + 1;
    if (surfaces_.are_simple()) return;
    next_->passes[at] = now_->passes[place];
    next_->view_distance[at] = 0;
    next_->media[at] = now_->media[place];
    sent_on_ |= uint64_t{1} << place;
  }

  static constexpr size_t kMostBundles = (RayBatch::kMost + kLanes - 1) / kLanes;
  const Surfaces& surfaces_;
  std::span<const SampleKey> keys_;
  HitBundle bundles_[kMostBundles];
  WaitingSegments waiting_;  ///< of what is not simple
  uint64_t sent_on_ = 0;     ///< a bit for each place of the front with a segment in the next one
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
