#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "front/free_camera.h"
#include "front/rendered_picture.h"
#include "job/job.h"
#include "studio/page_message.h"
#include "studio/scene_reading.h"

namespace tessera {

/// One frame at its full size and with all its samples. Never changes.
struct FullFrame {
  std::shared_ptr<const SceneReading> reading{};
  std::shared_ptr<const RenderOptions> options{};
  std::optional<FreeCamera> camera{};  ///< in place of the scene's
  std::optional<int> number{};         ///< in its animation
};

/// What `tessera render` would be asked for to get that picture, without output files. Throws
/// usage_error for an option that is none of those that say what to render.
RenderOptions full_options(const page::Render& wish, const std::string& scene_path);

/// The number under which FrameRender has to make a frame that is asked for as `frame`: nothing for
/// the first one of a scene that is the same in each.
std::optional<int> frame_number(const FrameScene& scene, std::optional<int> frame);

/// The job that `tessera render` submits for that frame. Throws Error for options that do not go
/// with the scene.
JobSpec job_of(const FullFrame& frame);

/// What `tessera render` makes of its result: denoised, with metadata and statistics. Takes seconds
/// for large pictures. Throws where the job failed.
std::shared_ptr<const RenderedPicture> picture_of(const FullFrame& frame, JobResult result,
                                                  double seconds);

/// A film that was traced in passes as a picture, with what files tell of it.
std::shared_ptr<const RenderedPicture> picture_of(const FullFrame& frame, const Film& film);

/// The film that was traced for that frame, smoothed as its options ask for.
std::shared_ptr<const Film> denoised(const FullFrame& frame, const Film& film);

/// The command line that makes that picture, for a shell; empty where none does, as the camera was
/// moved by hand. `folder`: the opened one, in which its files are; `assets`: holds what scenes
/// name, empty where the opened one does. Both absolute.
std::string command_line(const page::Render& wish, const std::string& folder,
                         const std::string& assets);

}  // namespace tessera
