#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "front/picture.h"
#include "front/tracing_farm.h"
#include "job/job.h"

namespace tessera {

/// A finished picture, or what was done of one: the film and what files and statistics tell of it.
/// Nobody changes one that was handed out.
struct RenderedPicture {
  Film film;
  v1::Output output;  ///< what the scene asks of its numbers
  ImageMetadata metadata{};
  JobReport report{};
  std::string statistics{};  ///< as `--stats` writes; empty: of no render
};

/// One frame that a farm renders. Made by one thread, run by the farm's, watched by any.
class FrameTask {
 public:
  /// Throws usage_error for options that do not go with the scene. `parse_seconds` is what reading
  /// it took.
  FrameTask(RenderOptions options, LoadedScene loaded, std::optional<int> frame,
            double parse_seconds);

  /// Whether it is done, or was within that time.
  bool wait(std::chrono::microseconds time) const;
  bool is_done() const { return wait(std::chrono::microseconds(0)); }
  /// Ends it soon, if it is not done; its picture then holds what came until then.
  void cancel() { stop_ = true; }
  bool is_cancelled() const { return stop_; }
  JobProgress progress() const;

  /// From now on take_tiles() has what becomes done.
  void keep_tiles();
  /// Tiles that became done since the last call.
  std::vector<PixelRect> take_tiles();
  /// What is done of the picture, the rest black. Null before the first tile, and without
  /// keep_tiles().
  std::shared_ptr<RenderedPicture> snapshot() const;

  /// The picture, or what was done of it; null where there is none. Once it is done.
  std::shared_ptr<RenderedPicture> picture() const;
  /// Throws what it failed with, if it did. Once it is done.
  void throw_failure() const;

  // Called by the farm's thread.
  void run(TracingFarm& farm);
  void fail(std::exception_ptr failure);

 private:
  void trace(TracingFarm& farm);
  void take(const NewTiles& news);
  void finish(JobResult result);

  const RenderOptions options_;
  LoadedScene loaded_;
  const v1::FrameSettings settings_;
  const v1::Output output_;
  const std::string scene_digest_;
  const double parse_seconds_;
  uint64_t peak_worker_bytes_ = 0;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::atomic<bool> stop_{false};
  std::atomic<bool> keeps_tiles_{false};

  mutable std::mutex mutex_;
  mutable std::condition_variable ended_;
  bool is_done_ = false;
  JobProgress progress_;
  std::optional<Film> partial_;
  std::vector<PixelRect> new_tiles_;
  std::shared_ptr<RenderedPicture> picture_;
  std::exception_ptr failure_;
};

}  // namespace tessera
