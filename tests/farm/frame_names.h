#pragma once

#include <map>
#include <string>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera::testing {

/// What a worker that is played by hand has to repeat: how the coordinator names itself and its
/// frames.
class FrameNames {
 public:
  /// Takes notice of a message of the coordinator.
  void note(const v1::Envelope& message) {
    if (message.has_welcome()) opening_ = message.welcome().opening();
    if (message.has_job_start()) {
      frames_[message.job_start().job()] = message.job_start().frame_id();
    }
  }
  /// Fills in what is not set yet in a message of a worker.
  void complete(v1::Envelope& message) const {
    if (message.has_heartbeat()) {
      for (auto& job : *message.mutable_heartbeat()->mutable_jobs()) name_frame(job);
      for (auto& held : *message.mutable_heartbeat()->mutable_progress()) name_opening(held);
    }
    if (message.has_scene_ready()) name_frame(*message.mutable_scene_ready());
    if (message.has_scene_failed()) name_frame(*message.mutable_scene_failed());
    if (message.has_tile_failed()) {
      name_frame(*message.mutable_tile_failed());
      name_opening(*message.mutable_tile_failed());
    }
    if (message.has_tile_band()) {
      name_frame(*message.mutable_tile_band());
      name_opening(*message.mutable_tile_band());
    }
  }

 private:
  template <typename Message>
  void name_frame(Message& message) const {
    const auto it = frames_.find(message.job());
    if (message.frame_id().empty() && it != frames_.end()) message.set_frame_id(it->second);
  }
  template <typename Message>
  void name_opening(Message& message) const {
    if (message.opening().empty()) message.set_opening(opening_);
  }

  std::string opening_;
  std::map<uint64_t, std::string> frames_;  ///< by the number of the job
};

}  // namespace tessera::testing
