#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "front/render_frame.h"
#include "front/rendered_picture.h"
#include "front/tracing_farm.h"
#include "job/job.h"

namespace tessera {

/// One frame that a farm renders. Made by one thread, run by the farm's, watched by any.
class FrameTask {
 public:
  /// Throws usage_error for options that do not go with the scene.
  FrameTask(RenderOptions options, FrameScene scene, std::optional<int> frame);

  /// Whether it is done, or was within that time.
  bool wait(std::chrono::microseconds time) const;
  bool is_done() const { return wait(std::chrono::microseconds(0)); }
  /// Ends it soon, at once where it has not begun; its picture then holds what came until then.
  void cancel();
  /// As cancel(), sooner: nobody wants what came until then.
  void abandon();
  JobProgress progress() const;

  /// From now on take_tiles() has what becomes done.
  void keep_tiles();
  /// Tiles that became done since the last call.
  std::vector<PixelRect> take_tiles();
  /// What is done of the picture, the rest black. Until it is done, null before the first tile and
  /// without keep_tiles().
  std::shared_ptr<RenderedPicture> snapshot() const;

  /// The picture, or what was done of it; null where there is none. Once it is done.
  std::shared_ptr<RenderedPicture> picture() const;
  /// Throws what it failed with, if it did. Once it is done.
  void throw_failure() const;
  /// What is to be told of the picture. Once it is done.
  std::vector<std::string> warnings() const;

  /// Says that others of the same farm come first.
  void queue();
  // Called by the farm's thread.
  void run(TracingFarm& farm);
  void fail(std::exception_ptr failure);

 private:
  void trace(TracingFarm& farm);
  void take(const NewTiles& news);
  void tell_traced(const JobReport& report);
  std::shared_ptr<RenderedPicture> with_statistics(RenderedPicture made) const;
  double seconds_since_it_began() const;
  void end(std::shared_ptr<RenderedPicture> picture, std::exception_ptr failure);

  const RenderOptions options_;
  FrameScene scene_;
  const v1::Output output_;
  const FrameRender frame_;
  uint64_t peak_worker_bytes_ = 0;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::atomic<bool> has_begun_{false};  ///< or will never begin
  std::atomic<bool> stop_{false};
  std::atomic<bool> is_abandoned_{false};
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
