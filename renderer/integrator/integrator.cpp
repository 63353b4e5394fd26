#include "renderer/integrator/integrator.h"

#include "renderer/integrator/path_tracer.h"
#include "renderer/integrator/views.h"
#include "renderer/integrator/whitted.h"

namespace tessera {

void TraceCounters::add_to(CounterMap& map) const {
  map["node_visits"] += traversal.node_visits;
  map["primitive_tests"] += traversal.primitive_tests;
  map["rays_primary"] += rays_primary;
  map["rays_shadow"] += rays_shadow;
  map["rays_reflection"] += rays_reflection;
  map["rays_refraction"] += rays_refraction;
  map["hits"] += hits;
  map["shadow_rays_skipped"] += shadow_rays_skipped;
  map["samples"] += samples;
  map["samples_skipped"] += samples_skipped;
  if (roulette_ends > 0) map["roulette_ends"] += roulette_ends;
  if (paths_cut > 0) map["paths_cut"] += paths_cut;  // told only when it happened
  map["nan_samples"] += nan_samples;
}

std::unique_ptr<const Integrator> make_integrator(std::shared_ptr<const Scene> scene) {
  const RenderSettings& settings = scene->settings;
  if (auto view = make_surface_view(scene, settings.view)) return view;
  auto integrator =
      settings.integrator == IntegratorKind::path ? make_path_tracer(scene) : make_whitted(scene);
  if (settings.view == View::cost) return make_cost_view(std::move(integrator));
  return integrator;
}

}  // namespace tessera
