#include "front/frame_task.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/cancellation.h"
#include "front/picture.h"
#include "front/picture_warnings.h"
#include "front/statistics.h"

namespace tessera {
namespace {

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

FrameTask::FrameTask(RenderOptions options, FrameScene scene, std::optional<int> frame)
    : options_(std::move(options)),
      scene_(std::move(scene)),
      output_(scene_.loaded.scene.settings().output()),
      frame_(options_, scene_, frame) {}

bool FrameTask::wait(std::chrono::microseconds time) const {
  std::unique_lock lock(mutex_);
  return ended_.wait_for(lock, time, [this] { return is_done_; });
}

JobProgress FrameTask::progress() const {
  const std::lock_guard lock(mutex_);
  JobProgress progress = progress_;
  if (!is_done_) progress.elapsed_seconds = seconds_since_it_began();
  return progress;
}

double FrameTask::seconds_since_it_began() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
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

std::vector<std::string> FrameTask::warnings() const {
  const std::lock_guard lock(mutex_);
  if (!picture_) return {};
  return report_warnings(picture_->report,
                         {.is_whole = shows_whole_frame(picture_->film, frame_.settings())});
}

void FrameTask::cancel() {
  stop_ = true;
  if (has_begun_.exchange(true)) return;
  JobReport report;
  report.end = JobReport::End::interrupted;
  end(nullptr, std::make_exception_ptr(*frame_.failure(report)));
}

void FrameTask::abandon() {
  is_abandoned_ = true;
  cancel();
}

void FrameTask::queue() {
  const std::lock_guard lock(mutex_);
  progress_.waiting_for = "another picture of the same farm";
}

void FrameTask::run(TracingFarm& farm) {
  if (has_begun_.exchange(true)) return;
  {
    const std::lock_guard lock(mutex_);
    progress_.waiting_for.clear();
  }
  try {
    trace(farm);
  } catch (...) {
    end(nullptr, std::current_exception());
  }
}

void FrameTask::fail(std::exception_ptr failure) {
  if (!has_begun_.exchange(true)) end(nullptr, std::move(failure));
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
  JobResult result = frame_.trace(
      farm, scene_.loaded,
      [this](const JobProgress& progress) {
        const std::lock_guard lock(mutex_);
        progress_ = progress;
      },
      stop_);
  peak_worker_bytes_ = farm.peak_worker_bytes();
  // It is not needed while the picture is denoised, which takes memory too.
  scene_.loaded = {};
  std::optional<RenderedPicture> picture;
  if (result.report.end == JobReport::End::done) {
    tell_traced(result.report);
    try {
      const Cancellation cancellation(&stop_);
      picture = frame_.picture(result);
    } catch (const WorkCancelled&) {
      result.report.end = JobReport::End::interrupted;
    }
  }
  if (picture) return end(with_statistics(std::move(*picture)), nullptr);
  const Error failure = *frame_.failure(result.report);
  if (result.report.tiles_done > 0 && !is_abandoned_) {
    picture = frame_.picture(result);
    return end(with_statistics(std::move(*picture)), std::make_exception_ptr(failure));
  }
  end(nullptr, std::make_exception_ptr(failure));
}

void FrameTask::tell_traced(const JobReport& report) {
  const std::lock_guard lock(mutex_);
  progress_.tiles_done = report.tiles_done;
  progress_.tiles_total = report.tiles_total;
  progress_.remaining_seconds = 0;
  if (is_denoised(options_.denoise, report, frame_.settings()))
    progress_.waiting_for = "the denoiser";
}

std::shared_ptr<RenderedPicture> FrameTask::with_statistics(RenderedPicture made) const {
  auto picture = std::make_shared<RenderedPicture>(std::move(made));
  const PhaseSeconds seconds{.parse = scene_.load_seconds,
                             .write = 0,
                             .total = scene_.load_seconds + seconds_since_it_began()};
  FrameStatistics statistics = frame_.statistics(*picture, seconds, peak_worker_bytes_);
  statistics.pixels_sha256 = picture->film.pixels_sha256();
  picture->statistics = statistics_json(statistics).dump();
  return picture;
}

void FrameTask::end(std::shared_ptr<RenderedPicture> picture, std::exception_ptr failure) {
  scene_.loaded = {};
  const std::lock_guard lock(mutex_);
  if (picture) {
    progress_.tiles_done = std::max(progress_.tiles_done, picture->report.tiles_done);
    progress_.tiles_total = picture->report.tiles_total;
    partial_.reset();
  }
  progress_.elapsed_seconds = seconds_since_it_began();
  progress_.remaining_seconds = 0;
  progress_.waiting_for.clear();
  picture_ = std::move(picture);
  failure_ = std::move(failure);
  is_done_ = true;
  ended_.notify_all();
}

}  // namespace tessera
