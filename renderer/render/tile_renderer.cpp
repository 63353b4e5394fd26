#include "renderer/render/tile_renderer.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "base/error.h"
#include "renderer/integrator/integrator.h"
#include "renderer/scene/scene.h"

namespace tessera {

namespace {

bool is_finite(const Color& c) {
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}

class SceneTileRenderer final : public TileRenderer {
 public:
  explicit SceneTileRenderer(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)), integrator_(make_integrator(scene_)) {}

  CounterMap build_counters() const override { return scene_->counters; }

  std::optional<TilePixels> render(const RenderTask& task, TileProgress& progress) const override {
    const PixelRect frame{0, 0, scene_->settings.width, scene_->settings.height};
    TESSERA_CHECK(!task.rect.empty() && frame.contains(task.rect) && task.sample_count > 0,
                  fmt::format("[{},{})x[{},{}) of {}x{}, {} samples", task.rect.x0, task.rect.x1,
                              task.rect.y0, task.rect.y1, frame.x1, frame.y1, task.sample_count));
    const auto start = std::chrono::steady_clock::now();
    TilePixels tile;
    tile.rect = task.rect;
    tile.values.reserve(static_cast<size_t>(task.rect.area()) * kFilmChannels);
    TraceState state;
    // A level of recursion leaves at most one segment waiting.
    state.stack.reserve(scene_->features.secondary ? scene_->settings.max_depth + 2 : 0);
    for (int y = task.rect.y0; y < task.rect.y1; ++y) {
      if (progress.cancelled.load(std::memory_order_relaxed)) return std::nullopt;
      for (int x = task.rect.x0; x < task.rect.x1; ++x) {
        const Color mean = trace_pixel(x, y, task, state);
        for (const double channel : {mean.r, mean.g, mean.b}) {
          tile.values.push_back(static_cast<float>(channel));
        }
      }
      progress.work_done.fetch_add(1, std::memory_order_relaxed);
    }
    state.counters.add_to(tile.counters);
    tile.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return tile;
  }

 private:
  /// The mean of the task's samples, added in the order of their numbers.
  Color trace_pixel(int x, int y, const RenderTask& task, TraceState& state) const {
    Color sum = kBlack;
    for (uint32_t i = 0; i < task.sample_count; ++i) {
      const uint32_t sample = task.first_sample + i;
      const Vec2 raster = scene_->sampler->raster_point(x, y, sample);
      const Ray ray = scene_->camera->ray(raster.x, raster.y);
      const Color color = integrator_->radiance(ray, {x, y, sample}, state);
      ++state.counters.samples;
      if (is_finite(color)) {
        sum += color;
      } else {
        ++state.counters.nan_samples;
      }
    }
    return task.sample_count == 1 ? sum : sum * (1.0 / task.sample_count);
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const Integrator> integrator_;
};

}  // namespace

std::shared_ptr<const TileRenderer> make_tile_renderer(const v1::Scene& scene,
                                                       const BlobStore& blobs,
                                                       const v1::FrameSettings& frame,
                                                       int threads) {
  return std::make_shared<SceneTileRenderer>(build_scene(scene, blobs, frame, threads));
}

}  // namespace tessera
