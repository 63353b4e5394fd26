#include "renderer/render/adaptive_tile.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "renderer/film/block.h"
#include "renderer/render/block_estimate.h"
#include "renderer/scene/light_by_chance.h"

namespace tessera {

namespace {

PixelRect block_at(int x, int y, const PixelRect& frame) {
  const int x0 = x / kBlockSide * kBlockSide, y0 = y / kBlockSide * kBlockSide;
  return {x0, y0, std::min(x0 + kBlockSide, frame.x1), std::min(y0 + kBlockSide, frame.y1)};
}

bool contains_pixel(const PixelRect& rect, int x, int y) {
  return rect.contains({x, y, x + 1, y + 1});
}

class AdaptiveTile {
 public:
  AdaptiveTile(const Scene& scene, const SampleTracer& tracer, const HiddenLight& hidden,
               const RenderTask& task, TileState& state, TileWriter& writer)
      : scene_(scene),
        tracer_(tracer),
        hidden_(hidden),
        task_(task),
        state_(state),
        writer_(writer),
        shows_error_(scene.settings.view == View::error),
        light_by_chance_(shows_error_ ? light_by_chance(scene) : 1) {}

  /// Whether it was not cancelled.
  bool render() {
    const PixelRect frame{0, 0, scene_.settings.width, scene_.settings.height};
    const PixelRect& rect = task_.rect;
    const PixelRect first = block_at(rect.x0, rect.y0, frame);
    for (int y = first.y0; y < rect.y1; y += kBlockSide) {
      for (int x = first.x0; x < rect.x1; x += kBlockSide) {
        if (!render_block(block_at(x, y, frame))) return false;
      }
    }
    CounterMap& counts = writer_.counters();
    counts["rays_background_skipped"] = background_;
    counts["samples_saved"] = saved_;
    counts["blocks_stopped_early"] = stopped_;
    counts["samples_beside_the_tile"] = beside_.counters.samples;
    return true;
  }

 private:
  /// A pixel of the block that is being traced.
  struct Pixel {
    int x = 0, y = 0;
    bool wanted = false;  ///< it is of the task
    bool seen = false;
    SampleSum sum;
  };
  using Pixels = std::array<Pixel, BlockEstimate::kMaxPixels>;

  bool render_block(const PixelRect& block) {
    Pixels pixels;
    const size_t count = begin_block(block, pixels);
    const SamplePattern pattern = scene_.settings.sampler.pattern;
    const uint32_t first_look = scene_.settings.first_look();
    BlockEstimate estimate(static_cast<int>(count), pattern != SamplePattern::independent,
                           scene_.sampler->filter_gain(), first_look, shows_error_,
                           light_by_chance_);
    std::array<double, BlockEstimate::kMaxPixels> errors{};
    uint32_t done = 0, looked = 0;
    bool converged = count == 0;
    while (!converged && done < task_.sample_count) {
      const uint32_t next = std::min(done == 0 ? first_look : 2 * done, task_.sample_count);
      if (!trace_samples(pixels, count, done, next, estimate)) return false;
      done = next;
      if (done < first_look || !std::has_single_bit(done)) continue;
      estimate.look(done, hidden_.square_error(block.x0, block.y0, static_cast<int>(count), done));
      converged = estimate.most_taken_off() < error_after(done, task_.sample_count);
      looked = done;
      if (shows_error_ && (converged || 2 * done > task_.sample_count)) {
        errors = estimate.standard_errors();
      }
    }
    const bool early = count > 0 && done < task_.sample_count;
    if (early && contains_pixel(task_.rect, block.x0, block.y0)) ++stopped_;
    for (size_t i = 0; i < count; ++i) {
      if (!pixels[i].wanted) continue;
      saved_ += task_.sample_count - done;
      if (!pixels[i].seen) background_ += done;
      std::optional<double> error;
      // Samples since the latest look take off at least what independent ones would.
      if (shows_error_ && looked > 0) error = errors[i] * std::sqrt(1.0 * looked / done);
      writer_.put(pixels[i].sum, pixels[i].x, pixels[i].y, pixels[i].seen, error);
    }
    return true;
  }

  /// Of each pixel those from number `begin` up to `end`. Whether it was not cancelled.
  bool trace_samples(Pixels& pixels, size_t count, uint32_t begin, uint32_t end,
                     BlockEstimate& estimate) {
    WaitingSamples waiting(tracer_);
    for (uint32_t i = 0; i < count; ++i) {
      const Pixel& pixel = pixels[i];
      TraceState& counted = pixel.wanted ? state_ : beside_;
      const auto take = [&](uint32_t of, const Sample& found) {
        pixels[of].sum.add(found);
        estimate.add(static_cast<int>(of), found.color);
      };
      const auto trace_waiting = [&] {
        waiting.trace(counted,
                      [&](const SampleKey&, uint32_t of, const Sample& found) { take(of, found); });
        return writer_.progress().go_on();
      };
      const bool in_row = tracer_.goes_in_batches() && pixel.seen;
      for (uint32_t sample = begin; sample < end; ++sample) {
        const SampleKey key{pixel.x, pixel.y, task_.first_sample + sample};
        if (in_row) {
          waiting.add(key, i);
          if (waiting.is_full() && !trace_waiting()) return false;
        } else {
          take(i, tracer_.find(key, counted, SampleTracer::way_of(pixel.seen)));
          const bool tells =
              (sample + 1 - begin) % tracer_.samples_at_once() == 0 || sample + 1 == end;
          if (tells && !writer_.progress().go_on()) return false;
        }
      }
      // What is counted apart is traced apart.
      const bool is_last = i + 1 == count || pixels[i + 1].wanted != pixel.wanted;
      if (is_last && !waiting.empty() && !trace_waiting()) return false;
    }
    return true;
  }

  /// Below this a block may stop: the target where all samples were taken, and less the fewer were.
  /// By the root of their number: then what one sample more takes off the square error, which is
  /// about what it lost by the latest doubling over n, is the same for all blocks when they stop,
  /// and no other shares of as many samples make a better picture.
  double error_after(uint32_t done, uint32_t most) const {
    const double all = std::min(most, kDefaultMostSamples);
    return scene_.settings.target_error * std::min(1.0, std::sqrt(done / all));
  }

  /// The pixels that the decision is about. Those past everything, where all such pixels are alike,
  /// are not: they have all their samples, as where a whole tile is filled with them.
  size_t begin_block(const PixelRect& block, Pixels& pixels) {
    size_t count = 0;
    for (int y = block.y0; y < block.y1; ++y) {
      for (int x = block.x0; x < block.x1; ++x) {
        const bool wanted = contains_pixel(task_.rect, x, y), seen = is_seen(scene_, x, y);
        if (seen || !is_uniform_beyond(scene_)) {
          pixels[count++] = {x, y, wanted, seen, tracer_.empty_sum()};
        } else if (wanted) {
          writer_.put(state_.sum_beyond(), x, y, seen);
          background_ += task_.sample_count;
        }
      }
    }
    return count;
  }

  const Scene& scene_;
  const SampleTracer& tracer_;
  const HiddenLight& hidden_;
  const RenderTask& task_;
  TileState& state_;
  /// What is traced for the decision alone is counted apart: the rest does not depend on how the
  /// frame is cut.
  TraceState beside_;
  TileWriter& writer_;
  bool shows_error_;
  double light_by_chance_;
  uint64_t background_ = 0, saved_ = 0, stopped_ = 0;
};

}  // namespace

bool render_adaptively(const Scene& scene, const SampleTracer& tracer, const HiddenLight& hidden,
                       const RenderTask& task, TileState& state, TileWriter& writer) {
  return AdaptiveTile(scene, tracer, hidden, task, state, writer).render();
}

}  // namespace tessera
