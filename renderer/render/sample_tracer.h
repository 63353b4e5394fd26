#pragma once

#include <cmath>
#include <memory>
#include <span>

#include "base/uninitialized.h"
#include "renderer/accel/ray_batch.h"
#include "renderer/film/tile.h"
#include "renderer/integrator/integrator.h"
#include "renderer/render/sample_sum.h"
#include "renderer/render/through_camera.h"
#include "renderer/render/tile_renderer.h"
#include "renderer/sampler/draw_rasters.h"
#include "renderer/scene/scene.h"

namespace tessera {

/// What the samples of a scene's pixels find. Each is counted, and black where it is no colour that
/// a pixel can hold. Immutable; any thread, each with its state.
class SampleTracer {
 public:
  explicit SampleTracer(std::shared_ptr<const Scene> scene);

  /// How a sample is found.
  using Way = Sample (SampleTracer::*)(const SampleKey&, TraceState&) const;
  Sample trace(const SampleKey& key, TraceState& state) const;
  /// The same where the state has the sample's cone.
  Sample trace_in_cone(const SampleKey& key, TraceState& state) const;
  /// Of a pixel past everything: what tracing would give, without tracing.
  Sample look_past(const SampleKey& key, TraceState& state) const;
  /// The same before a background of one colour, or one that is left out.
  Sample constant_background(const SampleKey& key, TraceState& state) const;
  static Way way_of(bool seen) { return seen ? &SampleTracer::trace : &SampleTracer::look_past; }

  Sample find(const SampleKey& key, TraceState& state, Way way) const {
    return finite((this->*way)(key, state), state);
  }
  /// What trace() finds of 1 to samples_of_row() samples that go in batches: calls take(place,
  /// sample) of each in their order.
  template <typename Take>
  void trace_batch(std::span<const SampleKey> keys, TraceState& state, const Take& take) const;

  bool goes_in_batches() const { return samples_of_row_ > 0; }
  /// How many fill a batch with rays through the lens; 0: each is traced by itself.
  uint32_t samples_of_row() const { return samples_of_row_; }
  /// How many samples of a pixel are traced between two reports of its progress.
  uint32_t samples_at_once() const { return samples_at_once_; }
  /// Whether all samples of a pixel are alike, and traced once.
  bool samples_coincide() const { return samples_coincide_; }
  uint32_t traced_of(const RenderTask& task) const {
    return samples_coincide_ ? 1 : task.sample_count;
  }

  /// Of a pixel whose samples are to be added.
  SampleSum empty_sum() const;
  /// The task's samples, added in the order of their numbers. Whether it was not cancelled.
  bool add_samples(SampleSum& sum, int x, int y, const RenderTask& task, TraceState& state, Way way,
                   TileProgress& progress) const;

 private:
  static Sample finite(Sample sample, TraceState& state) {
    ++state.counters.samples;
    if (!is_representable(sample.color)) {
      sample.color = kBlack;
      ++state.counters.nan_samples;
    }
    return sample;
  }

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const Integrator> integrator_;
  DrawRasters draw_rasters_;
  uint32_t samples_of_row_;
  uint32_t samples_at_once_;
  bool samples_coincide_;
};

template <typename Take>
void SampleTracer::trace_batch(std::span<const SampleKey> keys, TraceState& state,
                               const Take& take) const {
  Uninitialized<Sampler::RasterSample, RayBatch::kMost> rasters;
  Uninitialized<Color, RayBatch::kMost> colors;
  draw_rasters_(*scene_->sampler, keys, {rasters.data(), keys.size()});
  through_camera<RayBatch::kMost>(*scene_, *integrator_, keys, {rasters.data(), keys.size()},
                                  {colors.data(), keys.size()}, state);
  for (size_t i = 0; i < keys.size(); ++i) take(i, finite({colors[i], rasters[i].negative}, state));
}

/// Samples that are to be traced together.
class WaitingSamples {
 public:
  /// Of samples that go in batches; `tracer` must outlive it.
  explicit WaitingSamples(const SampleTracer& tracer) : tracer_(tracer) {}

  bool empty() const { return count_ == 0; }
  bool is_full() const { return count_ >= tracer_.samples_of_row(); }
  /// Where it is not full. `pixel` is what the caller knows the sample's pixel by.
  void add(const SampleKey& key, uint32_t pixel) {
    keys_[count_] = key;
    pixels_[count_++] = pixel;
  }
  /// Calls take(key, pixel, sample) of each, in their order, and leaves none waiting.
  template <typename Take>
  void trace(TraceState& state, const Take& take) {
    if (empty()) return;
    tracer_.trace_batch({keys_.data(), count_}, state, [&](size_t i, const Sample& sample) {
      take(keys_[i], pixels_[i], sample);
    });
    count_ = 0;
  }

 private:
  const SampleTracer& tracer_;
  Uninitialized<SampleKey, RayBatch::kMost> keys_;
  Uninitialized<uint32_t, RayBatch::kMost> pixels_;
  size_t count_ = 0;
};

}  // namespace tessera
