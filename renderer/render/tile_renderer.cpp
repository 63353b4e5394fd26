#include "renderer/render/tile_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/render/adaptive_tile.h"
#include "renderer/render/aov_tracer.h"
#include "renderer/render/sample_tracer.h"
#include "renderer/render/tile_state.h"
#include "renderer/render/tile_writer.h"
#include "renderer/scene/scene_builder.h"

namespace tessera {

namespace {

PixelRect intersection(const PixelRect& a, const PixelRect& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

class SceneTileRenderer final : public TileRenderer {
 public:
  explicit SceneTileRenderer(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)), tracer_(scene_), aovs_(scene_) {
    const bool is_adaptive = scene_->settings.target_error > 0 && !tracer_.samples_coincide();
    if (is_adaptive) hidden_.emplace(*scene_, tracer_);
  }

  CounterMap build_counters() const override { return scene_->counters; }

  std::optional<TilePixels> render(const RenderTask& task, TileProgress& progress) const override {
    const PixelRect frame{0, 0, scene_->settings.width, scene_->settings.height};
    TESSERA_CHECK(!task.rect.empty() && frame.contains(task.rect) && task.sample_count > 0,
                  fmt::format("[{},{})x[{},{}) of {}x{}, {} samples", task.rect.x0, task.rect.x1,
                              task.rect.y0, task.rect.y1, frame.x1, frame.y1, task.sample_count));
    TilePixels tile;
    tile.rect = task.rect;
    tile.channels = aovs_.aovs().channels();
    tile.values.resize(static_cast<size_t>(task.rect.area()) * static_cast<size_t>(tile.channels));
    TileState state;
    tile.counters["rays_background_skipped"] = 0;
    tile.counters["tiles_background"] = intersection(scene_->seen, task.rect).empty() ? 1 : 0;
    if (is_uniform_beyond(*scene_) && !scene_->seen.contains(task.rect)) {
      state.beyond = pixel_beyond(task);
    }
    TileWriter writer(*scene_, aovs_, task.first_sample, tile, progress);
    const bool done = hidden_ ? render_adaptively(*scene_, tracer_, *hidden_, task, state, writer)
                              : render_pixels(task, state, writer);
    if (!done || progress.cancelled.load(std::memory_order_relaxed)) return std::nullopt;
    state.counters.add_to(tile.counters);
    if (!aovs_.aovs().empty()) tile.counters["rays_aov"] = writer.rays_beside_light();
    if (scene_->built_when_hit)
      tile.counters["meshes_built_when_hit"] = scene_->built_when_hit->built.exchange(0);
    return tile;
  }

  bool builds() const override {
    return scene_->built_when_hit && scene_->built_when_hit->under_way > 0;
  }

  std::optional<Unseen> unseen(uint32_t sample_count) const override {
    if (!is_uniform_beyond(*scene_)) return std::nullopt;
    Unseen unseen{scene_->seen, {}};
    const PixelRect one{0, 0, 1, 1};
    unseen.one_pixel.rect = one;
    unseen.one_pixel.channels = aovs_.aovs().channels();
    unseen.one_pixel.values.resize(static_cast<size_t>(unseen.one_pixel.channels));
    const PixelBeyond pixel = pixel_beyond({one, 0, sample_count});
    TileProgress unwatched;
    TileWriter(*scene_, aovs_, 0, unseen.one_pixel, unwatched).put(pixel.sum, 0, 0, false);
    pixel.counters.add_to(unseen.one_pixel.counters);
    unseen.one_pixel.counters["rays_background_skipped"] = sample_count;
    unseen.one_pixel.counters["tiles_background"] = 1;
    return unseen;
  }

 private:
  /// Of squares of pixels whose lone samples fill a batch.
  static constexpr int kSquareSide = 8;
  static_assert(kSquareSide * kSquareSide == RayBatch::kMost);

  PixelBeyond pixel_beyond(const RenderTask& task) const {
    TraceState state;
    SampleSum sum = tracer_.empty_sum();
    TileProgress unwatched;
    tracer_.add_samples(sum, 0, 0, task, state, &SampleTracer::constant_background, unwatched);
    return {sum, state.counters};
  }
  /// Whether it was not cancelled.
  bool render_pixels(const RenderTask& task, TileState& state, TileWriter& writer) const {
    uint64_t unseen_pixels = 0;
    const bool is_lone = shows_one_sample(task);
    state.cone = scene_->cones.of(task.first_sample);
    WaitingPixels waiting{WaitingSamples(tracer_), tracer_.empty_sum()};
    for (const PixelRect& part : parts_of(task.rect, is_lone && tracer_.goes_in_batches())) {
      for (int y = part.y0; y < part.y1; ++y) {
        for (int x = part.x0; x < part.x1; ++x) {
          const bool seen = is_seen(*scene_, x, y);
          if (tracer_.goes_in_batches() && seen) {
            if (!wait_for(x, y, task, waiting, state, writer)) return false;
            continue;
          }
          if (!seen) ++unseen_pixels;
          if (!seen && is_uniform_beyond(*scene_)) {
            writer.put(state.sum_beyond(), x, y, seen);
          } else if (is_lone) {
            writer.put_lone(lone_sample(x, y, task, state, seen), x, y);
          } else {
            SampleSum sum = tracer_.empty_sum();
            const SampleTracer::Way way = SampleTracer::way_of(seen);
            if (!tracer_.add_samples(sum, x, y, task, state, way, writer.progress())) return false;
            writer.put(sum, x, y, seen);
          }
          if (!writer.progress().go_on()) return false;
        }
      }
      if (!put_waiting(task, waiting, state, writer)) return false;
    }
    writer.counters()["rays_background_skipped"] = unseen_pixels * task.sample_count;
    return true;
  }
  /// Of pixels that are traced together the rays go much the same way.
  static std::vector<PixelRect> parts_of(const PixelRect& rect, bool in_blocks) {
    if (!in_blocks) return {rect};
    std::vector<PixelRect> parts;
    for (int y = rect.y0; y < rect.y1; y += kSquareSide) {
      for (int x = rect.x0; x < rect.x1; x += kSquareSide) {
        const PixelRect part{x, y, x + kSquareSide, y + kSquareSide};
        parts.push_back(intersection(part, rect));
      }
    }
    return parts;
  }

  /// Pixels whose samples are to be traced together.
  struct WaitingPixels {
    WaitingSamples samples;
    SampleSum sum;  ///< of the first of them, as far as it is traced
  };
  /// Whether it was not cancelled.
  bool wait_for(int x, int y, const RenderTask& task, WaitingPixels& waiting, TraceState& state,
                TileWriter& writer) const {
    const uint32_t traced = tracer_.traced_of(task);
    state.counters.samples_skipped += task.sample_count - traced;
    for (uint32_t i = 0; i < traced; ++i) {
      waiting.samples.add({x, y, task.first_sample + i}, i);
      if (waiting.samples.is_full() && !put_waiting(task, waiting, state, writer)) return false;
    }
    return true;
  }
  bool put_waiting(const RenderTask& task, WaitingPixels& waiting, TraceState& state,
                   TileWriter& writer) const {
    if (waiting.samples.empty()) return true;
    const uint32_t last = tracer_.traced_of(task) - 1;
    const bool is_lone = shows_one_sample(task);
    uint64_t done = 0;
    waiting.samples.trace(state, [&](const SampleKey& key, uint32_t number, const Sample& sample) {
      done += number == last;
      if (is_lone) return writer.put_lone(sample, key.x, key.y);
      waiting.sum.add(sample);
      if (number != last) return;
      writer.put(waiting.sum, key.x, key.y, true);
      waiting.sum = tracer_.empty_sum();
    });
    return writer.progress().go_on(std::max(done, uint64_t{1}));
  }

  /// Whether a pixel is nothing but what its only sample finds.
  bool shows_one_sample(const RenderTask& task) const {
    const View view = scene_->settings.view;
    return (tracer_.samples_coincide() || task.sample_count == 1) && aovs_.aovs().empty() &&
           view != View::samples && view != View::error && scene_->sampler->filter_gain() == 1;
  }
  /// Of such a pixel; the sample's cone is set.
  Sample lone_sample(int x, int y, const RenderTask& task, TraceState& state, bool seen) const {
    state.counters.samples_skipped += task.sample_count - 1;
    return tracer_.find({x, y, task.first_sample}, state,
                        seen ? &SampleTracer::trace_in_cone : &SampleTracer::look_past);
  }

  std::shared_ptr<const Scene> scene_;
  SampleTracer tracer_;
  AovTracer aovs_;
  std::optional<HiddenLight> hidden_;  ///< by adaptive sampling alone
};

}  // namespace

std::shared_ptr<const TileRenderer> make_tile_renderer(const v1::Scene& scene,
                                                       const BlobStore& blobs,
                                                       const v1::FrameSettings& frame, int threads,
                                                       const Sharing& sharing) {
  return std::make_shared<SceneTileRenderer>(build_scene(scene, blobs, frame, threads, sharing));
}

}  // namespace tessera
