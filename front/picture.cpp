#include "front/picture.h"

#include "base/error.h"
#include "base/process.h"
#include "renderer/denoise/denoiser.h"
#include "renderer/film/auto_exposure.h"

namespace tessera {

void check_picture_options(const RenderOptions& options, const v1::FrameSettings& settings) {
  crop_window(options, settings);
  if (options.denoise) check_denoisable(settings);
  if (options.transparent_background) check_shows_light("--transparent-background", settings);
}

void check_denoisable(const v1::FrameSettings& settings) {
  check_shows_light("--denoise", settings);
  if (settings.samples_per_pixel() > 1) return;
  throw usage_error("--denoise: one sample tells nothing of its noise; expected --spp 2 or more");
}

JobSpec picture_job(const RenderOptions& options, const LoadedScene& loaded,
                    const v1::FrameSettings& settings) {
  return {.scene = loaded.scene,
          .blobs = loaded.blobs,
          .frame = settings,
          .crop = crop_window(options, settings),
          .tile_size = options.tile_size,
          .kept_tiles = options.resume ? kept_tiles_path(options) : std::filesystem::path()};
}

bool is_denoised(bool is_asked_for, const JobReport& report, const v1::FrameSettings& settings) {
  return is_asked_for && report.end == JobReport::End::done && report.holes.empty() &&
         settings.samples_per_pixel() > 1;
}

void finish_picture(const RenderOptions& options, const v1::FrameSettings& settings,
                    JobResult& result) {
  if (is_denoised(options.denoise, result.report, settings)) denoise(result.film, core_count());
  const AovSet aovs = picture_aovs(options);
  if (result.film.aovs() != aovs) result.film = result.film.with_only(aovs);
}

OutputSettings shown_settings(const std::string& scene_file, const RenderedPicture& picture,
                              const OutputOptions& options) {
  OutputSettings settings = output_settings(scene_file, picture.output, options);
  if (options.auto_exposure)
    settings.exposure =
        picture.auto_exposure ? *picture.auto_exposure : auto_exposure(picture.film);
  return settings;
}

ImageMetadata picture_metadata(const v1::FrameSettings& settings, bool is_denoised,
                               const v1::Output& of_scene, const std::string& scene_digest) {
  return {.scene_digest = scene_digest,
          .seed = settings.seed(),
          .samples_per_pixel = settings.samples_per_pixel(),
          .denoiser = is_denoised ? kDenoiserName : "",
          .colors = colors_of(of_scene),
          .frame_width = static_cast<int>(settings.width()),
          .frame_height = static_cast<int>(settings.height())};
}

}  // namespace tessera
