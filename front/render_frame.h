#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "base/error.h"
#include "front/render_options.h"
#include "front/rendered_picture.h"
#include "front/statistics.h"
#include "front/tracing_farm.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// A scene as frames of it are rendered.
struct FrameScene {
  LoadedScene loaded;
  std::string digest{};     ///< of the description
  double load_seconds = 0;  ///< what loading it took
};
/// The one that `load` returns.
FrameScene measured(const std::function<LoadedScene()>& load);

/// One frame on its way from options and scene to its picture, for every front end.
class FrameRender {
 public:
  /// Throws usage_error for options that do not go with the scene. `options` must outlive it.
  FrameRender(const RenderOptions& options, const FrameScene& scene, std::optional<int> frame);
  /// The same with so many samples a pixel.
  FrameRender with_samples(uint32_t samples) const;

  const v1::FrameSettings& settings() const { return settings_; }
  /// How many samples all of it takes, at the most.
  uint64_t sample_count() const;

  /// The job that traces it. `scene` is the one that it was made with.
  JobSpec job(const LoadedScene& scene) const;
  /// Has it traced until `stop` is set. `scene` is the one that it was made with.
  JobResult trace(TracingFarm& farm, LoadedScene& scene, const ProgressCallback& progress,
                  const std::atomic<bool>& stop) const;
  /// What it failed with; nothing where it is done.
  std::optional<Error> failure(const JobReport& report) const;
  /// What was asked for of what was traced, without statistics. Takes film and report out of
  /// `result`, which is left as it was where a Cancellation of the caller ends it.
  RenderedPicture picture(JobResult& result) const;
  /// What --stats tells of it, but for the digest of its pixels.
  FrameStatistics statistics(const RenderedPicture& picture, const PhaseSeconds& seconds,
                             uint64_t peak_worker_bytes) const;

 private:
  const RenderOptions* options_;
  v1::Output output_;
  std::string scene_digest_;
  v1::FrameSettings settings_;
};

}  // namespace tessera
