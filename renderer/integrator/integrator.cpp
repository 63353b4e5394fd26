#include "renderer/integrator/integrator.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/uninitialized.h"
#include "renderer/accel/ray_batch.h"
#include "renderer/integrator/batch_tracer.h"
#include "renderer/integrator/path_batches.h"
#include "renderer/integrator/views.h"
#include "renderer/integrator/whitted_batches.h"

namespace tessera {

namespace {

/// Follows all rays in batches; a single one is a batch of one.
class BatchIntegrator final : public Integrator {
 public:
  explicit BatchIntegrator(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)),
        batches_(scene_->settings.integrator == IntegratorKind::path
                     ? make_path_batches(*scene_)
                     : make_whitted_batches(*scene_)) {}

  Color background(const Ray& ray) const override {
    return scene_->background.radiance(ray.origin, ray.direction, scene_->lights);
  }
  Color radiance(const Ray& ray, const SampleKey& key, TraceState& state) const override {
    Color found;
    batches_->radiances({&ray, 1}, {&key, 1}, {&found, 1}, state);
    return found;
  }
  const BatchTracer* batches() const override { return batches_.get(); }

 private:
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const BatchTracer> batches_;
};

}  // namespace

void TraceCounters::add_to(CounterMap& map) const {
  map["node_visits"] += traversal.node_visits;
  map["primitive_tests"] += traversal.primitive_tests;
  map["rays_primary"] += rays_primary;
  map["rays_shadow"] += rays_shadow;
  map["rays_reflection"] += rays_reflection;
  map["rays_refraction"] += rays_refraction;
  map["hits"] += hits;
  map["shadow_rays_skipped"] += shadow_rays_skipped;
  const auto add_if_any = [&](const char* name, uint64_t n) {
    if (n > 0) map[name] += n;
  };
  add_if_any("occluders_met_again", occluders_met_again);
  add_if_any("lights_culled", lights_culled);
  add_if_any("branches_skipped", branches_skipped);
  add_if_any("texture_points_skipped", texture_points_skipped);
  add_if_any("numbers_skipped", numbers_skipped);
  map["samples"] += samples;
  map["samples_skipped"] += samples_skipped;
  add_if_any("roulette_ends", roulette_ends);
  add_if_any("paths_cut", paths_cut);
  map["nan_samples"] += nan_samples;
}

void Integrator::radiances(std::span<const Ray> rays, std::span<const SampleKey> keys,
                           std::span<Color> found, TraceState& state) const {
  if (const BatchTracer* const batches = this->batches())
    return batches->radiances(rays, keys, found, state);
  for (size_t i = 0; i < rays.size(); ++i) found[i] = radiance(rays[i], keys[i], state);
}

void Integrator::radiances(const Camera& camera, std::span<const Sampler::RasterSample> rasters,
                           std::span<const SampleKey> keys, std::span<Color> found,
                           TraceState& state) const {
  const BatchTracer* const batches = this->batches();
  const Pinhole* const pinhole = camera.pinhole();
  if (batches && pinhole) return batches->radiances(*pinhole, rasters, keys, found, state);
  TESSERA_CHECK(rasters.size() <= RayBatch::kMost, fmt::format("{} rays", rasters.size()));
  Uninitialized<Ray, RayBatch::kMost> rays;
  for (size_t i = 0; i < rasters.size(); ++i)
    rays[i] = camera.ray(rasters[i].point.x, rasters[i].point.y);
  radiances({rays.data(), rasters.size()}, keys, found, state);
}

std::unique_ptr<const Integrator> make_integrator(std::shared_ptr<const Scene> scene) {
  const RenderSettings& settings = scene->settings;
  if (auto view = make_surface_view(scene, settings.view)) return view;
  auto integrator = std::make_unique<BatchIntegrator>(scene);
  if (settings.view == View::cost) return make_cost_view(std::move(integrator));
  return integrator;
}

}  // namespace tessera
