#pragma once

#include <bit>
#include <cstdint>
#include <memory>

#include "job/job.h"
#include "renderer/render/tile_renderer.h"

namespace tessera::testing {

/// A value that depends on the pixel, the samples and the seed, and on nothing else.
inline float pixel_value(int x, int y, int channel, const RenderTask& task, uint32_t seed) {
  uint64_t key = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u + static_cast<uint64_t>(y);
  key = (key ^ key >> 31) * 0xbf58476d1ce4e5b9u + static_cast<uint64_t>(channel) + seed;
  key = (key ^ key >> 29) * 0x94d049bb133111ebu + task.first_sample + task.sample_count;
  return static_cast<float>((key ^ key >> 32) >> 40) * 0x1p-24f;
}

/// Traces nothing: its pixels are a hash of the task.
class FakeRenderer : public TileRenderer {
 public:
  explicit FakeRenderer(uint32_t seed) : seed_(seed) {}
  std::optional<TilePixels> render(const RenderTask& task, TileProgress& progress) const override {
    TilePixels pixels;
    pixels.rect = task.rect;
    pixels.values.reserve(static_cast<size_t>(task.rect.area()) * kFilmChannels);
    for (int y = task.rect.y0; y < task.rect.y1; ++y) {
      if (progress.cancelled) return std::nullopt;
      for (int x = task.rect.x0; x < task.rect.x1; ++x) {
        for (int c = 0; c < kFilmChannels; ++c) {
          pixels.values.push_back(pixel_value(x, y, c, task, seed_));
        }
      }
      ++progress.work_done;
    }
    pixels.counters["rays_primary"] = static_cast<uint64_t>(task.rect.area()) * task.sample_count;
    return pixels;
  }
  CounterMap build_counters() const override { return {{"build_skipped", 3}}; }

 private:
  uint32_t seed_;
};

inline std::shared_ptr<const TileRenderer> make_fake_renderer(const v1::Scene&, const BlobStore&,
                                                              const v1::FrameSettings& frame, int) {
  return std::make_shared<FakeRenderer>(frame.seed());
}

/// A job with a scene, a blob that it names, and a frame.
inline JobSpec make_job(int width, int height, int tile_size, size_t blob_bytes = 100) {
  JobSpec job;
  job.scene.mutable_metadata()->set_title("a scene of the farm's tests");
  job.blobs.put(std::vector<std::byte>(blob_bytes, std::byte{7}));
  job.frame.set_width(static_cast<uint32_t>(width));
  job.frame.set_height(static_cast<uint32_t>(height));
  job.frame.set_samples_per_pixel(4);
  job.frame.set_seed(5);
  job.crop = {0, 0, width, height};
  job.tile_size = tile_size;
  return job;
}

/// What make_job's film must hash to.
inline std::string expected_sha256(const JobSpec& job) {
  Film film(job.crop);
  TileProgress progress;
  const auto pixels =
      FakeRenderer(job.frame.seed()).render({job.crop, 0, job.frame.samples_per_pixel()}, progress);
  film.write(job.crop, job.crop.y0, job.crop.height(), pixels->values);
  return film.pixels_sha256();
}

}  // namespace tessera::testing
