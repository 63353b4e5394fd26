#include "coordinator/jobs/check_kept_job.h"

#include <fmt/format.h>

#include <utility>

#include "base/digest.h"
#include "base/error.h"
#include "coordinator/jobs/frame_number.h"
#include "job/check_job.h"
#include "job/job_messages.h"

namespace tessera {

void check_kept_job(const v1::KeptJob& kept) {
  const v1::SubmitJob& request = kept.request();
  if (kept.job() < 1 || kept.job() > kMaxJobNumber) {
    throw usage_error(fmt::format("number {}; expected 1 to {}", kept.job(), kMaxJobNumber));
  }
  const int frames = request.frames_size();
  if (frames < 1 || std::cmp_greater(frames, kMaxFrames) || kept.tile_keys_size() != frames) {
    throw usage_error(fmt::format("{} frames and {} keys of tiles; expected one key a frame",
                                  frames, kept.tile_keys_size()));
  }
  if (request.tile_size() < 1 || request.tile_size() > static_cast<uint32_t>(kMaxFrameSide)) {
    throw usage_error(
        fmt::format("tile size {}; expected 1 to {}", request.tile_size(), kMaxFrameSide));
  }
  if (request.priority() < -kMostPriority || request.priority() > kMostPriority) {
    throw usage_error(fmt::format("priority {}; expected {} to {}", request.priority(),
                                  -kMostPriority, kMostPriority));
  }
  JobSpec probe;
  probe.crop = rect_of(request.crop());
  probe.tile_size = static_cast<int>(request.tile_size());
  for (int i = 0; i < frames; ++i) {
    if (!Digest::parse(kept.tile_keys(i)) || !Digest::parse(request.frames(i).scene_digest())) {
      throw usage_error(fmt::format("frame {} without the digest of its scene or tiles", i + 1));
    }
    probe.frame = request.frames(i).settings();
    check_job(probe);
  }
}

}  // namespace tessera
