#include "renderer/render/sample_tracer.h"

#include <algorithm>
#include <utility>

#include "renderer/accel/bvh_kernels.h"

namespace tessera {

namespace {

/// Whether nothing tells the samples of a pixel apart: all at its centre, and nothing drawn by lot.
bool all_coincide(const Scene& scene) {
  return scene.settings.sampler.pattern == SamplePattern::center && !scene.settings.draws_lots() &&
         scene.camera->lens_samples() == 0 &&
         std::none_of(scene.materials.begin(), scene.materials.end(),
                      [](const Material& material) { return material.grain > 0; });
}

uint32_t samples_in_a_row(const Scene& scene) {
  constexpr uint32_t kRays = RayBatch::kMost;
  return kRays / std::clamp(scene.camera->lens_samples(), 1u, kRays);
}

}  // namespace

SampleTracer::SampleTracer(std::shared_ptr<const Scene> scene)
    : scene_(std::move(scene)),
      integrator_(make_integrator(scene_)),
      draw_rasters_(raster_drawer(*scene_->sampler, kernels().name)),
      samples_of_row_(integrator_->batches() ? samples_in_a_row(*scene_) : 0),
      samples_at_once_(tessera::samples_at_once(*scene_)),
      samples_coincide_(all_coincide(*scene_)) {}

Sample SampleTracer::trace(const SampleKey& key, TraceState& state) const {
  state.cone = scene_->cones.of(key.sample);
  return trace_in_cone(key, state);
}

Sample SampleTracer::trace_in_cone(const SampleKey& key, TraceState& state) const {
  const auto [color, negative] = through_camera(
      *scene_, key,
      [&](const Ray& ray, const SampleKey& own) { return integrator_->radiance(ray, own, state); });
  return {color, negative};
}

Sample SampleTracer::look_past(const SampleKey& key, TraceState&) const {
  const auto [color, negative] = through_camera(
      *scene_, key, [&](const Ray& ray, const SampleKey&) { return integrator_->background(ray); });
  return {color, negative};
}

Sample SampleTracer::constant_background(const SampleKey&, TraceState&) const {
  if (scene_->settings.aovs.has(Aov::alpha)) return {kBlack};
  return {integrator_->background({})};
}

SampleSum SampleTracer::empty_sum() const {
  const RenderSettings& settings = scene_->settings;
  const bool spreads = settings.aovs.has(Aov::variance) || settings.view == View::error;
  return SampleSum(scene_->sampler->filter_gain(), spreads);
}

bool SampleTracer::add_samples(SampleSum& sum, int x, int y, const RenderTask& task,
                               TraceState& state, Way way, TileProgress& progress) const {
  const uint32_t traced = traced_of(task);
  state.counters.samples_skipped += task.sample_count - traced;
  for (uint32_t begin = 0, end = 0;; begin = end) {
    end = begin + std::min(traced - begin, samples_at_once_);
    for (uint32_t i = begin; i < end; ++i) sum.add(find({x, y, task.first_sample + i}, state, way));
    if (end == traced) return true;
    if (!progress.go_on()) return false;
  }
}

}  // namespace tessera
