#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "coordinator/coordinator.h"
#include "proto/wire/pixels.h"
#include "tests/farm/frame_names.h"

namespace tessera::testing {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A coordinator, and workers and clients that are played by hand.
class CoordinatorTest : public ::testing::Test {
 protected:
  static JobSpec job(int side = 32) {
    JobSpec spec;
    spec.frame.set_width(static_cast<uint32_t>(side));
    spec.frame.set_height(static_cast<uint32_t>(side));
    spec.frame.set_samples_per_pixel(1);
    spec.crop = {0, 0, side, side};
    spec.tile_size = 16;
    return spec;
  }

  v1::Envelope hello(WorkerId id, uint64_t session = 1) const {
    v1::Envelope message;
    v1::Hello& hello = *message.mutable_hello();
    hello.set_protocol_major(kProtocolMajor);
    hello.set_numerics_id(kNumericsId);
    hello.set_worker_id(id);
    hello.set_session(session);
    hello.set_credit(2);
    return message;
  }

  /// What is missing of the names of frames is filled in, as a worker would.
  void say(const PeerId& peer, v1::Envelope message, Time now = {}, const AllowedKey& sender = {}) {
    listen();
    names.complete(message);
    coordinator.on_message(Channel::control, peer, message, now, sender);
  }

  void listen() {
    for (auto& out : coordinator.take_outgoing()) {
      names.note(out.message);
      to.push_back(out.peer);
      all.push_back(std::move(out.message));
    }
  }

  /// All that was said since last asked, by kind.
  std::vector<v1::Envelope> heard(v1::Envelope::MessageCase kind) {
    listen();
    std::vector<v1::Envelope> result;
    for (const auto& message : all) {
      if (message.message_case() == kind) result.push_back(message);
    }
    return result;
  }

  uint64_t job_id() { return heard(v1::Envelope::kJobStart).back().job_start().job(); }

  void ready(const PeerId& peer, uint64_t job, Time now = {}) {
    v1::Envelope message;
    message.mutable_scene_ready()->set_session(1);
    message.mutable_scene_ready()->set_job(job);
    say(peer, message, now);
  }

  static v1::Envelope band(const v1::Assign& assign, float value) {
    const std::vector<float> values(16 * 16 * 3, value);
    v1::Envelope message;
    v1::TileBand& band = *message.mutable_tile_band();
    band = encode_bands(values, 16, assign.rect().y0(), false)[0];
    band.set_job(assign.job());
    band.set_lease(assign.lease());
    band.set_tile(assign.tile());
    return message;
  }

  Coordinator coordinator{CoordinatorOptions{}};
  std::vector<v1::Envelope> all;
  std::vector<PeerId> to;  ///< whom each of `all` was said
  FrameNames names;
};

}  // namespace tessera::testing
