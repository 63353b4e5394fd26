#include "front/render_frame.h"

#include <chrono>
#include <utility>

#include "front/located.h"
#include "front/output_settings.h"
#include "front/picture.h"
#include "proto/wire/scene_codec.h"
#include "renderer/film/auto_exposure.h"

namespace tessera {

FrameScene measured(const std::function<LoadedScene()>& load) {
  const auto start = std::chrono::steady_clock::now();
  FrameScene scene{.loaded = load()};
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  scene.load_seconds = taken.count();
  scene.digest = scene_digest(scene.loaded.scene);
  return scene;
}

FrameRender::FrameRender(const RenderOptions& options, const FrameScene& scene,
                         std::optional<int> frame)
    : options_(&options),
      output_(scene.loaded.scene.settings().output()),
      scene_digest_(scene.digest),
      settings_(frame_settings(options, scene.loaded.scene, frame)) {
  check_instant(options, frame.has_value());
  check_picture_options(options, settings_);
  output_settings(options.scene, output_, options.output);
}

FrameRender FrameRender::with_samples(uint32_t samples) const {
  FrameRender other = *this;
  other.settings_.set_samples_per_pixel(samples);
  return other;
}

uint64_t FrameRender::sample_count() const {
  return static_cast<uint64_t>(crop_window(*options_, settings_).area()) *
         settings_.samples_per_pixel();
}

JobSpec FrameRender::job(const LoadedScene& scene) const {
  return picture_job(*options_, scene, settings_);
}

JobResult FrameRender::trace(TracingFarm& farm, LoadedScene& scene,
                             const ProgressCallback& progress,
                             const std::atomic<bool>& stop) const {
  farm.share(scene.blobs);
  return farm.run(job(scene), progress, stop);
}

std::optional<Error> FrameRender::failure(const JobReport& report) const {
  switch (report.end) {
    case JobReport::End::done:
      return std::nullopt;
    case JobReport::End::interrupted:
      return Error(ExitCode::interrupted, "the render was cancelled");
    default:
      if (report.exit_code == ExitCode::bad_scene) return located(options_->scene, report.failure);
      return Error(report.exit_code, report.failure);
  }
}

RenderedPicture FrameRender::picture(JobResult& result) const {
  std::optional<double> exposure;
  if (options_->output.auto_exposure) exposure = auto_exposure(result.film);
  finish_picture(*options_, settings_, result);
  ImageMetadata metadata = picture_metadata(
      settings_, is_denoised(options_->denoise, result.report, settings_), output_, scene_digest_);
  return {.film = std::move(result.film),
          .output = output_,
          .metadata = std::move(metadata),
          .report = std::move(result.report),
          .auto_exposure = exposure};
}

FrameStatistics FrameRender::statistics(const RenderedPicture& picture, const PhaseSeconds& seconds,
                                        uint64_t peak_worker_bytes) const {
  return {.scene_digest = scene_digest_,
          .frame = settings_,
          .width = picture.film.width(),
          .height = picture.film.height(),
          .seconds = seconds,
          .report = picture.report,
          .peak_worker_bytes = peak_worker_bytes,
          .pixels_sha256 = {}};
}

}  // namespace tessera
