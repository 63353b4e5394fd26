#include "renderer/render/tile_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "renderer/integrator/integrator.h"
#include "renderer/scene/scene_builder.h"

namespace tessera {

namespace {

/// Whether a pixel can hold it: no NaN, and nothing beyond the range of float.
bool is_representable(const Color& c) {
  return std::isfinite(static_cast<float>(c.r)) && std::isfinite(static_cast<float>(c.g)) &&
         std::isfinite(static_cast<float>(c.b));
}

/// Whether nothing tells the samples of a pixel apart: all at its centre, and nothing drawn by lot.
bool all_coincide(const Scene& scene) {
  return scene.settings.sampler.pattern == SamplePattern::center && !scene.settings.draws_lots() &&
         scene.camera->lens_samples() == 0 &&
         std::none_of(scene.materials.begin(), scene.materials.end(),
                      [](const Material& material) { return material.grain > 0; });
}

class SceneTileRenderer final : public TileRenderer {
 public:
  explicit SceneTileRenderer(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)),
        integrator_(make_integrator(scene_)),
        samples_coincide_(all_coincide(*scene_)) {}

  CounterMap build_counters() const override { return scene_->counters; }

  std::optional<TilePixels> render(const RenderTask& task, TileProgress& progress) const override {
    const PixelRect frame{0, 0, scene_->settings.width, scene_->settings.height};
    TESSERA_CHECK(!task.rect.empty() && frame.contains(task.rect) && task.sample_count > 0,
                  fmt::format("[{},{})x[{},{}) of {}x{}, {} samples", task.rect.x0, task.rect.x1,
                              task.rect.y0, task.rect.y1, frame.x1, frame.y1, task.sample_count));
    TilePixels tile;
    tile.rect = task.rect;
    tile.values.reserve(static_cast<size_t>(task.rect.area()) * kFilmChannels);
    TraceState state;
    // A level of recursion leaves at most two segments waiting.
    state.stack.reserve(scene_->features.secondary &&
                                scene_->settings.integrator == IntegratorKind::whitted
                            ? 2 * scene_->settings.max_depth + 3
                            : 0);
    uint64_t unseen_pixels = 0;
    uint64_t work_done = progress.work_done.load(std::memory_order_relaxed);
    for (int y = task.rect.y0; y < task.rect.y1; ++y) {
      for (int x = task.rect.x0; x < task.rect.x1; ++x) {
        // A pixel of a million samples takes long: a row would be too coarse a step.
        if (progress.cancelled.load(std::memory_order_relaxed)) return std::nullopt;
        const bool seen = scene_->seen.contains({x, y, x + 1, y + 1});
        if (!seen) ++unseen_pixels;
        const Color mean = seen ? mean_of(x, y, task, state, &SceneTileRenderer::trace)
                                : unseen_pixel(x, y, task, state);
        for (const double channel : {mean.r, mean.g, mean.b}) {
          tile.values.push_back(static_cast<float>(channel));
        }
        progress.work_done.store(++work_done, std::memory_order_relaxed);
      }
    }
    state.counters.add_to(tile.counters);
    if (scene_->built_when_hit)
      tile.counters["meshes_built_when_hit"] = scene_->built_when_hit->exchange(0);
    tile.counters["rays_background_skipped"] = unseen_pixels * task.sample_count;
    tile.counters["tiles_background"] =
        unseen_pixels == static_cast<uint64_t>(task.rect.area()) ? 1 : 0;
    return tile;
  }

  std::optional<Unseen> unseen(uint32_t sample_count) const override {
    if (!scene_->background.is_constant()) return std::nullopt;
    Unseen unseen{scene_->seen, {}};
    TraceState state;
    const Color mean =
        mean_of(0, 0, {{}, 0, sample_count}, state, &SceneTileRenderer::constant_background);
    for (const double channel : {mean.r, mean.g, mean.b}) {
      unseen.one_pixel.values.push_back(static_cast<float>(channel));
    }
    state.counters.add_to(unseen.one_pixel.counters);
    unseen.one_pixel.counters["rays_background_skipped"] = sample_count;
    unseen.one_pixel.counters["tiles_background"] = 1;
    return unseen;
  }

 private:
  using SampleFunction = Color (SceneTileRenderer::*)(const SampleKey&, TraceState&) const;

  /// What `look` sees along the sample's camera ray, or the mean over the lens.
  template <typename Look>
  Color through_camera(const SampleKey& key, const Look& look) const {
    const Vec2 raster = scene_->sampler->raster_point(key.x, key.y, key.sample);
    const uint32_t lens_samples = scene_->camera->lens_samples();
    if (lens_samples == 0) return look(scene_->camera->ray(raster.x, raster.y));
    Color sum = kBlack;
    for (uint32_t i = 0; i < lens_samples; ++i) {
      const Vec2 u =
          scene_->sampler->pair(key.x, key.y, key.sample * lens_samples + i, SampleUse::lens);
      sum += look(scene_->camera->lens_ray(raster.x, raster.y, u));
    }
    return sum * (1.0 / lens_samples);
  }
  Color trace(const SampleKey& key, TraceState& state) const {
    return through_camera(key,
                          [&](const Ray& ray) { return integrator_->radiance(ray, key, state); });
  }
  Color look_past(const SampleKey& key, TraceState&) const {
    return through_camera(key, [&](const Ray& ray) { return integrator_->background(ray); });
  }
  Color constant_background(const SampleKey&, TraceState&) const {
    return integrator_->background({});
  }

  /// What tracing would give, without tracing. Where all pixels are alike not even a ray is made.
  Color unseen_pixel(int x, int y, const RenderTask& task, TraceState& state) const {
    return mean_of(x, y, task, state,
                   scene_->background.is_constant() ? &SceneTileRenderer::constant_background
                                                    : &SceneTileRenderer::look_past);
  }

  /// The mean of the task's samples, added in the order of their numbers.
  Color mean_of(int x, int y, const RenderTask& task, TraceState& state,
                SampleFunction sample_function) const {
    Color sum = kBlack;
    // Samples that are all alike are traced once.
    const uint32_t traced = samples_coincide_ ? 1 : task.sample_count;
    state.counters.samples_skipped += task.sample_count - traced;
    for (uint32_t i = 0; i < traced; ++i) {
      const Color color = (this->*sample_function)({x, y, task.first_sample + i}, state);
      ++state.counters.samples;
      if (is_representable(color)) {
        sum += color;
      } else {
        ++state.counters.nan_samples;
      }
    }
    return traced == 1 ? sum : sum * (1.0 / traced);
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const Integrator> integrator_;
  bool samples_coincide_;
};

}  // namespace

std::shared_ptr<const TileRenderer> make_tile_renderer(const v1::Scene& scene,
                                                       const BlobStore& blobs,
                                                       const v1::FrameSettings& frame, int threads,
                                                       const SharedArena* arena) {
  return std::make_shared<SceneTileRenderer>(build_scene(scene, blobs, frame, threads, arena));
}

}  // namespace tessera
