#include "client/submitted_job.h"

#include <random>
#include <span>
#include <string>

#include "job/job_messages.h"
#include "proto/wire/scene_codec.h"

namespace tessera {

uint64_t draw_submission() {
  std::random_device random;
  return (uint64_t{random()} << 32 | random()) | 1;
}

void add_frame(SubmittedJob& job, const JobSpec& frame, int number, const v1::Output& output) {
  for (const auto& [digest, data] : frame.blobs.all()) job.blobs.put(digest, data);
  const std::string scene = serialize_scene(frame.scene);
  const auto bytes = std::as_bytes(std::span(scene));
  v1::JobFrame& added = *job.request.add_frames();
  added.set_number(number);
  added.set_scene_size(scene.size());
  added.set_scene_digest(job.blobs.put({bytes.begin(), bytes.end()}).hex());
  *added.mutable_settings() = frame.frame;
  *added.mutable_output() = output;
  *job.request.mutable_crop() = to_message(frame.crop);
  job.request.set_tile_size(static_cast<uint32_t>(frame.tile_size));
}

}  // namespace tessera
