#include "renderer/render/tile_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/unmade.h"
#include "renderer/accel/bvh_kernels.h"
#include "renderer/film/block.h"
#include "renderer/integrator/integrator.h"
#include "renderer/render/aov_tracer.h"
#include "renderer/render/block_estimate.h"
#include "renderer/render/sample_sum.h"
#include "renderer/render/through_camera.h"
#include "renderer/sampler/raster_row.h"
#include "renderer/scene/light_by_chance.h"
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

PixelRect block_at(int x, int y, const PixelRect& frame) {
  const int x0 = x / kBlockSide * kBlockSide, y0 = y / kBlockSide * kBlockSide;
  return {x0, y0, std::min(x0 + kBlockSide, frame.x1), std::min(y0 + kBlockSide, frame.y1)};
}

bool contains_pixel(const PixelRect& rect, int x, int y) {
  return rect.contains({x, y, x + 1, y + 1});
}

PixelRect intersection(const PixelRect& a, const PixelRect& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

class SceneTileRenderer final : public TileRenderer {
 public:
  explicit SceneTileRenderer(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)),
        integrator_(make_integrator(scene_)),
        aovs_(scene_),
        samples_coincide_(all_coincide(*scene_) && scene_->skips.equal_samples),
        adaptive_(scene_->settings.target_error > 0 && !samples_coincide_ &&
                  scene_->skips.converged_blocks),
        samples_at_once_(samples_at_once(*scene_)),
        in_rows_(integrator_->rays_at_once() > 1),
        light_by_chance_(light_by_chance(*scene_)) {}

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
    TraceState beside_light;
    integrator_->make_room(state);
    tile.counters["rays_background_skipped"] = 0;
    tile.counters["tiles_background"] = intersection(scene_->seen, task.rect).empty() ? 1 : 0;
    if (scene_->background.is_constant() && !scene_->seen.contains(task.rect)) {
      state.beyond = pixel_beyond(task);
    }
    const Output output{task.first_sample, beside_light, tile, progress};
    const bool done = adaptive_ ? render_blocks(task, progress, state, output)
                                : render_pixels(task, progress, state, output);
    if (!done || progress.cancelled.load(std::memory_order_relaxed)) return std::nullopt;
    state.counters.add_to(tile.counters);
    if (!aovs_.aovs().empty()) tile.counters["rays_aov"] = beside_light.counters.rays_primary;
    if (scene_->built_when_hit)
      tile.counters["meshes_built_when_hit"] = scene_->built_when_hit->built.exchange(0);
    return tile;
  }

  bool builds() const override {
    return scene_->built_when_hit && scene_->built_when_hit->under_way > 0;
  }

  std::optional<Unseen> unseen(uint32_t sample_count) const override {
    if (!scene_->background.is_constant()) return std::nullopt;
    Unseen unseen{scene_->seen, {}};
    const PixelRect one{0, 0, 1, 1};
    unseen.one_pixel.rect = one;
    unseen.one_pixel.channels = aovs_.aovs().channels();
    unseen.one_pixel.values.resize(static_cast<size_t>(unseen.one_pixel.channels));
    const PixelBeyond pixel = pixel_beyond({one, 0, sample_count});
    TraceState beside_light;
    TileProgress unwatched;
    put(pixel.sum, 0, 0, false, {0, beside_light, unseen.one_pixel, unwatched});
    pixel.counters.add_to(unseen.one_pixel.counters);
    unseen.one_pixel.counters["rays_background_skipped"] = sample_count;
    unseen.one_pixel.counters["tiles_background"] = 1;
    return unseen;
  }

 private:
  static constexpr int kRowSide = 8;
  static constexpr uint32_t kRowSamples = kRowSide * kRowSide;
  using SampleFunction = Sample (SceneTileRenderer::*)(const SampleKey&, TraceState&) const;

  /// Where pixels go.
  struct Output {
    uint32_t first_sample = 0;
    TraceState& beside_light;  ///< what AOVs cost
    TilePixels& tile;
    TileProgress& progress;
  };
  /// A pixel past everything before a background of one colour: all of them are alike.
  struct PixelBeyond {
    SampleSum sum;
    TraceCounters counters;
  };
  struct TileState : TraceState {
    PixelBeyond beyond;  ///< set where the tile may have some and the background has one colour
  };
  PixelBeyond pixel_beyond(const RenderTask& task) const {
    TraceState state;
    SampleSum sum = empty_sum();
    TileProgress unwatched;
    add_samples(sum, 0, 0, task, state, &SceneTileRenderer::constant_background, unwatched);
    return {sum, state.counters};
  }
  /// Its samples, counted as if they had been worked out anew.
  static const SampleSum& sum_beyond(TileState& state) {
    const TraceCounters& counters = state.beyond.counters;
    state.counters.samples += counters.samples;
    state.counters.samples_skipped += counters.samples_skipped;
    state.counters.nan_samples += counters.nan_samples;
    return state.beyond.sum;
  }

  /// Whether it was not cancelled.
  bool render_pixels(const RenderTask& task, TileProgress& progress, TileState& state,
                     const Output& output) const {
    uint64_t unseen_pixels = 0;
    const bool is_lone = shows_one_sample(task);
    state.cone = scene_->cones.of(task.first_sample);
    WaitingPixels waiting(empty_sum());
    for (const PixelRect& part : parts_of(task.rect, is_lone && in_rows_)) {
      for (int y = part.y0; y < part.y1; ++y) {
        for (int x = part.x0; x < part.x1; ++x) {
          const bool seen = is_seen(x, y);
          if (in_rows_ && seen) {
            if (!wait_for(x, y, task, waiting, state, output)) return false;
            continue;
          }
          if (!seen) ++unseen_pixels;
          if (!seen && scene_->background.is_constant()) {
            put(sum_beyond(state), x, y, seen, output);
          } else if (is_lone) {
            put_color(lone_sample(x, y, task, state, seen), value_at(x, y, output.tile));
          } else {
            SampleSum sum = empty_sum();
            if (!add_samples(sum, x, y, task, state, way_of(seen), progress)) return false;
            put(sum, x, y, seen, output);
          }
          if (!progress.go_on()) return false;
        }
      }
      if (!put_waiting(task, waiting, state, output)) return false;
    }
    output.tile.counters["rays_background_skipped"] = unseen_pixels * task.sample_count;
    return true;
  }
  /// Of pixels that are traced together the rays go much the same way.
  static std::vector<PixelRect> parts_of(const PixelRect& rect, bool in_blocks) {
    if (!in_blocks) return {rect};
    std::vector<PixelRect> parts;
    for (int y = rect.y0; y < rect.y1; y += kRowSide) {
      for (int x = rect.x0; x < rect.x1; x += kRowSide) {
        const PixelRect part{x, y, x + kRowSide, y + kRowSide};
        parts.push_back(intersection(part, rect));
      }
    }
    return parts;
  }

  /// Samples that are to be traced together.
  struct WaitingSamples {
    Unmade<SampleKey, kRowSamples> keys;
    Unmade<uint32_t, kRowSamples> pixels;  ///< the number of each one's pixel among those that wait
    size_t count = 0;

    void add(const SampleKey& key, uint32_t pixel) {
      keys[count] = key;
      pixels[count++] = pixel;
    }
  };
  /// Whether more samples of this scene can wait. A lens fills rows by one sample, and may take
  /// long for it.
  bool has_room(const WaitingSamples& waiting) const {
    return waiting.count < (scene_->camera->lens_samples() > 0 ? 1 : kRowSamples);
  }
  /// Calls take(place, sample) with what each sample that waits finds, in their order, and leaves
  /// none waiting.
  template <typename Take>
  void trace_waiting(WaitingSamples& waiting, TraceState& state, const Take& take) const {
    if (waiting.count == 0) return;
    const std::span keys(waiting.keys.data(), std::exchange(waiting.count, 0));
    Unmade<Sampler::RasterSample, kRowSamples> rasters;
    Unmade<Color, kRowSamples> colors;
    draw_rasters(*scene_->sampler, keys, {rasters.data(), keys.size()}, kernels().name);
    through_camera<kRowSamples>(*scene_, *integrator_, keys, {rasters.data(), keys.size()},
                                {colors.data(), keys.size()}, state);
    for (size_t i = 0; i < keys.size(); ++i)
      take(i, finite({colors[i], rasters[i].negative}, state));
  }

  /// Pixels whose samples are to be traced together.
  struct WaitingPixels {
    explicit WaitingPixels(const SampleSum& empty) : sum(empty) {}
    WaitingSamples samples;
    SampleSum sum;  ///< of the first of them, as far as it is traced
  };
  /// Whether it was not cancelled.
  bool wait_for(int x, int y, const RenderTask& task, WaitingPixels& waiting, TraceState& state,
                const Output& output) const {
    const uint32_t traced = traced_of(task);
    state.counters.samples_skipped += task.sample_count - traced;
    for (uint32_t i = 0; i < traced; ++i) {
      waiting.samples.add({x, y, task.first_sample + i}, i);
      if (!has_room(waiting.samples) && !put_waiting(task, waiting, state, output)) return false;
    }
    return true;
  }
  bool put_waiting(const RenderTask& task, WaitingPixels& waiting, TraceState& state,
                   const Output& output) const {
    if (waiting.samples.count == 0) return true;
    const uint32_t last = traced_of(task) - 1;
    const bool is_lone = shows_one_sample(task);
    WaitingSamples& samples = waiting.samples;
    uint64_t done = 0;
    trace_waiting(samples, state, [&](size_t i, const Sample& sample) {
      const auto& [x, y, number] = samples.keys[i];
      done += number - task.first_sample == last;
      if (is_lone) {
        put_color(kBlack + sample.color, value_at(x, y, output.tile));  // no -0
        return;
      }
      waiting.sum.add(sample);
      if (number - task.first_sample != last) return;
      put(waiting.sum, x, y, true, output);
      waiting.sum = empty_sum();
    });
    return output.progress.go_on(std::max(done, uint64_t{1}));
  }
  /// Samples that are all alike are traced once.
  uint32_t traced_of(const RenderTask& task) const {
    return samples_coincide_ ? 1 : task.sample_count;
  }

  // ------------------------------------------------------------------------ adaptive sampling

  /// A pixel of the block that is being traced.
  struct BlockPixel {
    int x = 0, y = 0;
    bool wanted = false;  ///< it is of the task
    bool seen = false;
    SampleSum sum;
  };
  struct BlockCounters {
    uint64_t background = 0, saved = 0, stopped = 0;
  };

  bool render_blocks(const RenderTask& task, TileProgress& progress, TileState& state,
                     const Output& output) const {
    const PixelRect frame{0, 0, scene_->settings.width, scene_->settings.height};
    // What is traced for the decision alone is counted apart: the rest does not depend on how the
    // frame is cut.
    TraceState beside;
    beside.stack.reserve(state.stack.capacity());
    BlockCounters counters;
    const PixelRect first = block_at(task.rect.x0, task.rect.y0, frame);
    for (int y = first.y0; y < task.rect.y1; y += kBlockSide) {
      for (int x = first.x0; x < task.rect.x1; x += kBlockSide) {
        if (!render_block(block_at(x, y, frame), task, progress, state, beside, counters, output)) {
          return false;
        }
      }
    }
    CounterMap& counts = output.tile.counters;
    counts["rays_background_skipped"] = counters.background;
    counts["samples_saved"] = counters.saved;
    counts["blocks_stopped_early"] = counters.stopped;
    counts["samples_beside_the_tile"] = beside.counters.samples;
    return true;
  }

  bool render_block(const PixelRect& block, const RenderTask& task, TileProgress& progress,
                    TileState& state, TraceState& beside, BlockCounters& counters,
                    const Output& output) const {
    std::array<BlockPixel, BlockEstimate::kMaxPixels> pixels;
    const size_t count = begin_block(block, task, state, counters, output, pixels);
    const SamplePattern pattern = scene_->settings.sampler.pattern;
    const uint32_t first_look = scene_->settings.first_look();
    BlockEstimate estimate(static_cast<int>(count), pattern != SamplePattern::independent,
                           scene_->sampler->filter_gain(), first_look, shows_error(),
                           light_by_chance_);
    std::array<double, BlockEstimate::kMaxPixels> errors{};
    uint32_t done = 0, looked = 0;
    bool converged = count == 0;
    while (!converged && done < task.sample_count) {
      const uint32_t next = std::min(done == 0 ? first_look : 2 * done, task.sample_count);
      WaitingSamples waiting;
      for (uint32_t i = 0; i < count; ++i) {
        BlockPixel& pixel = pixels[i];
        TraceState& counted = pixel.wanted ? state : beside;
        const auto take = [&](uint32_t of, const Sample& found) {
          pixels[of].sum.add(found);
          estimate.add(static_cast<int>(of), found.color);
        };
        const auto take_waiting = [&](size_t place, const Sample& found) {
          take(waiting.pixels[place], found);
        };
        const bool in_row = in_rows_ && pixel.seen;
        for (uint32_t sample = done; sample < next; ++sample) {
          const SampleKey key{pixel.x, pixel.y, task.first_sample + sample};
          if (in_row) {
            waiting.add(key, i);
            if (has_room(waiting)) continue;
            trace_waiting(waiting, counted, take_waiting);
            if (!progress.go_on()) return false;
          } else {
            take(i, finite_sample(key, counted, way_of(pixel.seen)));
            const bool tells = (sample + 1 - done) % samples_at_once_ == 0 || sample + 1 == next;
            if (tells && !progress.go_on()) return false;
          }
        }
        // What is counted apart is traced apart.
        const bool is_last = i + 1 == count || pixels[i + 1].wanted != pixel.wanted;
        if (!is_last || waiting.count == 0) continue;
        trace_waiting(waiting, counted, take_waiting);
        if (!progress.go_on()) return false;
      }
      done = next;
      if (done < first_look || !std::has_single_bit(done)) continue;
      estimate.look(done);
      converged = estimate.most_taken_off() < error_after(done, task.sample_count);
      looked = done;
      if (shows_error() && (converged || 2 * done > task.sample_count)) {
        errors = estimate.standard_errors();
      }
    }
    const bool early = count > 0 && done < task.sample_count;
    if (early && contains_pixel(task.rect, block.x0, block.y0)) ++counters.stopped;
    for (size_t i = 0; i < count; ++i) {
      if (!pixels[i].wanted) continue;
      counters.saved += task.sample_count - done;
      if (!pixels[i].seen) counters.background += done;
      std::optional<double> error;
      // Samples since the latest look take off at least what independent ones would.
      if (shows_error() && looked > 0) error = errors[i] * std::sqrt(1.0 * looked / done);
      put(pixels[i].sum, pixels[i].x, pixels[i].y, pixels[i].seen, output, error);
    }
    return true;
  }

  /// Below this a block may stop: the target where all samples were taken, and less the fewer were.
  /// By the root of their number: then what one sample more takes off the square error, which is
  /// about what it lost by the latest doubling over n, is the same for all blocks when they stop,
  /// and no other shares of as many samples make a better picture.
  double error_after(uint32_t done, uint32_t most) const {
    const double all = std::min(most, kDefaultMostSamples);
    return scene_->settings.target_error * std::min(1.0, std::sqrt(done / all));
  }

  /// The pixels that the decision is about. Those past everything, where all such pixels are alike,
  /// are not: they have all their samples, as where a whole tile is filled with them.
  size_t begin_block(const PixelRect& block, const RenderTask& task, TileState& state,
                     BlockCounters& counters, const Output& output,
                     std::array<BlockPixel, BlockEstimate::kMaxPixels>& pixels) const {
    size_t count = 0;
    for (int y = block.y0; y < block.y1; ++y) {
      for (int x = block.x0; x < block.x1; ++x) {
        const bool wanted = contains_pixel(task.rect, x, y), seen = is_seen(x, y);
        if (seen || !scene_->background.is_constant()) {
          pixels[count++] = {x, y, wanted, seen, empty_sum()};
        } else if (wanted) {
          put(sum_beyond(state), x, y, seen, output);
          counters.background += task.sample_count;
        }
      }
    }
    return count;
  }

  // ------------------------------------------------------------------------------------- pixels

  SampleSum empty_sum() const {
    const bool spreads = aovs_.aovs().has(Aov::variance) || shows_error();
    return SampleSum(scene_->sampler->filter_gain(), spreads);
  }
  bool shows_error() const { return scene_->settings.view == View::error; }

  /// Of its light, or of how that was found. The standard error where it is known better than by
  /// the spread of the pixel's own samples.
  Color shown(const SampleSum& sum, std::optional<double> error) const {
    if (scene_->settings.view == View::samples) return kWhite * sum.count();
    if (!shows_error()) return sum.mean();
    if (error) return kWhite * *error;
    const Color variance = sum.variance();
    return kWhite * std::sqrt((variance.r + variance.g + variance.b) / 3);
  }

  void put(const SampleSum& sum, int x, int y, bool seen, const Output& output,
           std::optional<double> error = std::nullopt) const {
    float* value = put_color(shown(sum, error), value_at(x, y, output.tile));
    if (aovs_.aovs().empty()) return;
    aovs_.write(x, y, output.first_sample, seen, sum, output.beside_light, output.progress, value);
  }
  static float* value_at(int x, int y, TilePixels& tile) {
    const PixelRect& rect = tile.rect;
    const size_t at = static_cast<size_t>(int64_t{y - rect.y0} * rect.width() + (x - rect.x0));
    return &tile.values[at * static_cast<size_t>(tile.channels)];
  }
  /// Where what is beside light goes.
  static float* put_color(const Color& color, float* value) {
    for (const double channel : {color.r, color.g, color.b}) *value++ = static_cast<float>(channel);
    return value;
  }

  // ------------------------------------------------------------------------------------ samples

  bool is_seen(int x, int y) const { return scene_->seen.contains({x, y, x + 1, y + 1}); }

  /// How a pixel's samples are found. Of one past everything they are what tracing would give,
  /// without tracing.
  SampleFunction way_of(bool seen) const {
    return seen ? &SceneTileRenderer::trace : &SceneTileRenderer::look_past;
  }

  Sample trace(const SampleKey& key, TraceState& state) const {
    state.cone = scene_->cones.of(key.sample);
    return trace_in_cone(key, state);
  }
  Sample trace_in_cone(const SampleKey& key, TraceState& state) const {
    const auto [color, negative] =
        through_camera(*scene_, key, [&](const Ray& ray, const SampleKey& own) {
          return integrator_->radiance(ray, own, state);
        });
    return {color, negative};
  }
  Sample look_past(const SampleKey& key, TraceState&) const {
    const auto [color, negative] = through_camera(
        *scene_, key,
        [&](const Ray& ray, const SampleKey&) { return integrator_->background(ray); });
    return {color, negative};
  }
  Sample constant_background(const SampleKey&, TraceState&) const {
    return {integrator_->background({})};
  }

  /// Counted; black where it is no colour that a pixel can hold.
  Sample finite_sample(const SampleKey& key, TraceState& state,
                       SampleFunction sample_function) const {
    return finite((this->*sample_function)(key, state), state);
  }
  static Sample finite(Sample sample, TraceState& state) {
    ++state.counters.samples;
    if (!is_representable(sample.color)) {
      sample.color = kBlack;
      ++state.counters.nan_samples;
    }
    return sample;
  }
  /// The task's samples, added in the order of their numbers. Whether it was not cancelled.
  bool add_samples(SampleSum& sum, int x, int y, const RenderTask& task, TraceState& state,
                   SampleFunction sample_function, TileProgress& progress) const {
    const uint32_t traced = traced_of(task);
    state.counters.samples_skipped += task.sample_count - traced;
    for (uint32_t begin = 0, end = 0;; begin = end) {
      end = begin + std::min(traced - begin, samples_at_once_);
      for (uint32_t i = begin; i < end; ++i)
        sum.add(finite_sample({x, y, task.first_sample + i}, state, sample_function));
      if (end == traced) return true;
      if (!progress.go_on()) return false;
    }
  }

  /// Whether a pixel is nothing but what its only sample finds.
  bool shows_one_sample(const RenderTask& task) const {
    const View view = scene_->settings.view;
    return (samples_coincide_ || task.sample_count == 1) && aovs_.aovs().empty() &&
           view != View::samples && view != View::error && scene_->sampler->filter_gain() == 1;
  }
  /// sum_of(...).mean() of such a pixel; the sample's cone is set.
  Color lone_sample(int x, int y, const RenderTask& task, TraceState& state, bool seen) const {
    state.counters.samples_skipped += task.sample_count - 1;
    const SampleKey key{x, y, task.first_sample};
    const Sample sample = seen ? finite_sample(key, state, &SceneTileRenderer::trace_in_cone)
                               : finite_sample(key, state, &SceneTileRenderer::look_past);
    return kBlack + sample.color;  // no -0
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const Integrator> integrator_;
  AovTracer aovs_;
  bool samples_coincide_;
  bool adaptive_;
  uint32_t samples_at_once_;  ///< before it is told that a pixel gets on
  bool in_rows_;              ///< the integrator follows many rays faster than one
  double light_by_chance_;
};

}  // namespace

std::shared_ptr<const TileRenderer> make_tile_renderer(const v1::Scene& scene,
                                                       const BlobStore& blobs,
                                                       const v1::FrameSettings& frame, int threads,
                                                       const Sharing& sharing, const Skips& skips) {
  return std::make_shared<SceneTileRenderer>(
      build_scene(scene, blobs, frame, threads, sharing, skips));
}

}  // namespace tessera
