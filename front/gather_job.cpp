#include "front/gather_job.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "front/output_settings.h"
#include "front/picture_warnings.h"
#include "job/check_job.h"
#include "proto/wire/frame.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr size_t kMostNameTyped = 200;
/// It is one message; what is left of that is for the rest of the request.
constexpr size_t kMostFrameBytes = max_message_bytes(Channel::control) - (size_t{64} << 10);
constexpr size_t kFramingBytes = 16;  ///< of a frame in the request, and by which others may differ

/// Tells how to make several jobs of what is too much for one.
void check_count(const FrameNumbers& frames, size_t most) {
  if (frames.size() <= most) return;
  throw usage_error(
      fmt::format("--frames: {} frames; expected at most {} in one job: submit those before {} as "
                  "one, and those from there on as others",
                  frames.size(), most, frames[most]));
}

void check(const RenderOptions& options, const JobOrder& order) {
  check_instant(options, options.frames.has_value());
  if (options.frames) check_count(*options.frames, kMostJobFrames);
  if (order.name.size() > kMostNameTyped) {
    throw usage_error(fmt::format("--name: a name of {} bytes; expected at most {}",
                                  order.name.size(), kMostNameTyped));
  }
}

JobSpec spec_of(const RenderOptions& options, const LoadedScene& loaded, std::optional<int> frame) {
  JobSpec spec;
  spec.scene = loaded.scene;
  spec.blobs = loaded.blobs;
  spec.frame = frame_settings(options, loaded.scene, frame);
  spec.crop = crop_window(options, spec.frame);
  spec.tile_size = options.tile_size;
  check_job(spec);
  return spec;
}

}  // namespace

SubmittedJob gather_job(const RenderOptions& options, const JobOrder& order,
                        const std::function<LoadedScene(int frame)>& load,
                        const std::function<void(const std::string&)>& warn) {
  check(options, order);
  SubmittedJob job;
  job.request.set_submission(draw_submission());
  job.request.set_detached(true);
  job.request.set_priority(order.priority);
  job.request.set_weight(static_cast<uint32_t>(order.weight));
  job.request.set_animation(options.frames.has_value());
  job.request.set_name(to_utf8(
      order.name.empty() ? std::filesystem::path(options.scene).stem().string() : order.name));
  const FrameNumbers numbers = options.frames.value_or(FrameNumbers{0});
  LoadedScene loaded;
  std::set<std::string> warned;
  for (const int frame : numbers) {
    if (frame == numbers.front() || loaded.depends_on_frame) loaded = load(frame);
    for (const std::string& warning : scene_warnings(options, loaded)) {
      if (warned.insert(warning).second) warn(warning);
    }
    const JobSpec spec =
        spec_of(options, loaded, options.frames ? std::optional(frame) : std::nullopt);
    if (options.output.auto_exposure) {
      throw usage_error(
          "--exposure auto: a job has no picture yet; expected it at 'tessera fetch', or a number");
    }
    const v1::Output output = with_options(loaded.scene.settings().output(), options.output);
    if (output_settings(options.scene, output, options.output).color_management) {
      throw usage_error("--ocio-...: no job keeps these; expected them at 'tessera fetch'");
    }
    add_frame(job, spec, frame, output);
    // All are about as long as this one.
    const size_t bytes = job.request.frames().rbegin()->ByteSizeLong() + kFramingBytes;
    check_count(numbers, kMostFrameBytes / bytes);
  }
  return job;
}

}  // namespace tessera
