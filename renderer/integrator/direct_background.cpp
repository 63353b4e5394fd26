#include "renderer/integrator/direct_background.h"

#include "renderer/integrator/direct_light.h"
#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/path_vertex.h"
#include "renderer/integrator/surface_point.h"

namespace tessera {

namespace {

/// The number by which a path chooses whether it passes a surface.
struct PassingNumbers {
  const SampleStream& stream;
  uint32_t vertex;
  Vec2 pick() const {
    return stream.pair(static_cast<SampleUse>(VertexNumbers::use_of(vertex, VertexNumbers::kPick)));
  }
};

}  // namespace

DirectBackground direct_background(const Scene& scene, const Media& at_camera, Ray ray,
                                   const SampleKey& key, TraceState& state) {
  ++state.counters.rays_primary;
  const bool passes_by_chance = scene.settings.integrator == IntegratorKind::path;
  const SampleStream stream = scene.sampler->stream(key.x, key.y, key.sample);
  Color share = kWhite;
  Media media = at_camera;
  double path_length = 0;
  for (uint32_t pass = 0; pass < kMaxPasses; ++pass) {
    Hit hit;
    if (!scene.surfaces || !scene.surfaces->closest_hit(ray, hit, state.counters.traversal)) {
      return {share, share * scene.background.radiance(ray.origin, ray.direction, scene.lights)};
    }
    ++state.counters.hits;
    path_length += hit.t;
    SurfacePoint point(scene, hit.instance, ray, hit);
    look_up_textures(scene, ray, cone_width(state.cone, path_length), point, state.counters);
    note_media_before(media, point);
    if (!is_black(media.absorption())) share = share * transmittance(media.absorption(), hit.t);
    if (!passes_by_chance) {
      share = share * straight_coverage(point).through;
    } else if (!goes_straight(point, PassingNumbers{stream, pass})) {
      break;
    }
    if (max_component(share) < kFaintest) break;
    const double t_max = ray.t_max - hit.t;
    ray = spawn_ray(point.surface, ray.direction);
    ray.t_max = t_max;
    pass_into(media, point);
  }
  return {};
}

}  // namespace tessera
