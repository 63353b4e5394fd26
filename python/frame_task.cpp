#include "python/frame_task.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/digest.h"
#include "base/error.h"
#include "front/located.h"
#include "front/statistics.h"
#include "proto/wire/scene_codec.h"

namespace tessera {
namespace {

v1::FrameSettings checked_settings(const RenderOptions& options, const LoadedScene& loaded,
                                   std::optional<int> frame) {
  v1::FrameSettings settings = frame_settings(options, loaded.scene, frame);
  check_picture_options(options, settings);
  output_settings(options.scene, loaded.scene.settings().output());
  return settings;
}

/// Copies the light of a tile between films of one frame.
void copy_light(const NewTiles& from, const PixelRect& tile, Film& to) {
  const auto channels = static_cast<size_t>(from.channels);
  std::vector<float> row;
  for (int y = tile.y0; y < tile.y1; ++y) {
    const size_t first =
        static_cast<size_t>(y - from.film.y0) * static_cast<size_t>(from.film.width()) +
        static_cast<size_t>(tile.x0 - from.film.x0);
    row.clear();
    for (size_t pixel = first; pixel < first + static_cast<size_t>(tile.width()); ++pixel) {
      const auto light = from.values.subspan(pixel * channels, kFilmChannels);
      row.insert(row.end(), light.begin(), light.end());
    }
    to.write(tile, y, 1, row);
  }
}

}  // namespace

FrameTask::FrameTask(RenderOptions options, LoadedScene loaded, std::optional<int> frame,
                     double parse_seconds)
    : options_(std::move(options)),
      loaded_(std::move(loaded)),
      settings_(checked_settings(options_, loaded_, frame)),
      output_(loaded_.scene.settings().output()),
      scene_digest_(Digest::of(serialize_scene(loaded_.scene)).hex()),
      parse_seconds_(parse_seconds) {}

bool FrameTask::wait(std::chrono::microseconds time) const {
  std::unique_lock lock(mutex_);
  return ended_.wait_for(lock, time, [this] { return is_done_; });
}

JobProgress FrameTask::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

void FrameTask::keep_tiles() { keeps_tiles_ = true; }

std::vector<PixelRect> FrameTask::take_tiles() {
  const std::lock_guard lock(mutex_);
  return std::exchange(new_tiles_, {});
}

std::shared_ptr<RenderedPicture> FrameTask::snapshot() const {
  const std::lock_guard lock(mutex_);
  if (picture_) return picture_;
  if (!partial_) return nullptr;
  return std::make_shared<RenderedPicture>(
      RenderedPicture{.film = partial_->with_only({}), .output = output_});
}

std::shared_ptr<RenderedPicture> FrameTask::picture() const {
  const std::lock_guard lock(mutex_);
  return picture_;
}

void FrameTask::throw_failure() const {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

void FrameTask::run(TracingFarm& farm) {
  try {
    trace(farm);
  } catch (...) {
    fail(std::current_exception());
  }
}

void FrameTask::fail(std::exception_ptr failure) {
  const std::lock_guard lock(mutex_);
  failure_ = std::move(failure);
  is_done_ = true;
  ended_.notify_all();
}

void FrameTask::take(const NewTiles& news) {
  const std::lock_guard lock(mutex_);
  if (!partial_) partial_.emplace(news.film);
  for (const PixelRect& tile : news.tiles) copy_light(news, tile, *partial_);
  new_tiles_.insert(new_tiles_.end(), news.tiles.begin(), news.tiles.end());
}

void FrameTask::trace(TracingFarm& farm) {
  farm.watch_tiles(keeps_tiles_ ? TileCallback([this](const NewTiles& news) { take(news); })
                                : TileCallback());
  farm.share(loaded_.blobs);
  JobResult result = farm.run(
      picture_job(options_, loaded_, settings_),
      [this](const JobProgress& progress) {
        const std::lock_guard lock(mutex_);
        progress_ = progress;
      },
      stop_);
  peak_worker_bytes_ = farm.peak_worker_bytes();
  loaded_ = {};
  finish(std::move(result));
}

void FrameTask::finish(JobResult result) {
  std::exception_ptr failure;
  const JobReport& report = result.report;
  if (report.end == JobReport::End::interrupted) {
    failure = std::make_exception_ptr(Error(ExitCode::interrupted, "the render was cancelled"));
  } else if (report.end == JobReport::End::failed) {
    failure = std::make_exception_ptr(report.exit_code == ExitCode::bad_scene
                                          ? located(options_.scene, report.failure)
                                          : Error(report.exit_code, report.failure));
  }
  std::shared_ptr<RenderedPicture> picture;
  if (report.tiles_done > 0 || !failure) {
    finish_picture(options_, settings_, result);
    FrameStatistics statistics{
        .scene_digest = scene_digest_,
        .frame = settings_,
        .width = result.film.width(),
        .height = result.film.height(),
        .seconds = {.parse = parse_seconds_,
                    .write = 0,
                    .total = parse_seconds_ + std::chrono::duration<double>(
                                                  std::chrono::steady_clock::now() - began_)
                                                  .count()},
        .report = report,
        .peak_worker_bytes = peak_worker_bytes_,
        .pixels_sha256 = result.film.pixels_sha256()};
    std::string text = statistics_json(statistics).dump();
    ImageMetadata metadata = picture_metadata(settings_, is_denoised(options_, report, settings_),
                                              output_, scene_digest_);
    picture = std::make_shared<RenderedPicture>(RenderedPicture{.film = std::move(result.film),
                                                                .output = output_,
                                                                .metadata = std::move(metadata),
                                                                .report = std::move(result.report),
                                                                .statistics = std::move(text)});
  }
  const std::lock_guard lock(mutex_);
  progress_.tiles_done = std::max(progress_.tiles_done, picture ? picture->report.tiles_done : 0);
  if (picture) progress_.tiles_total = picture->report.tiles_total;
  progress_.remaining_seconds = 0;
  progress_.waiting_for.clear();
  picture_ = std::move(picture);
  partial_.reset();
  failure_ = std::move(failure);
  is_done_ = true;
  ended_.notify_all();
}

}  // namespace tessera
