#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "coordinator/jobs/memory_job_store.h"
#include "coordinator/tiles/identity.h"
#include "proto/wire/blob_transfer.h"
#include "proto/wire/scene_codec.h"
#include "tests/unit/coordinator/coordinator_fixture.h"

namespace tessera::testing {

/// A coordinator with a store, and jobs of clients.
class ServiceTest : public CoordinatorTest {
 protected:
  ServiceTest() {
    spdlog::set_level(spdlog::level::off);
    restart();
  }
  void restart() {
    limit([](CoordinatorOptions&) {});
  }
  /// Starts the coordinator anew with options that `adjust` changes.
  void limit(const std::function<void(CoordinatorOptions&)>& adjust) {
    CoordinatorOptions options;
    options.opening = opening_of(++openings);
    adjust(options);
    coordinator = Coordinator(options, store);
    all.clear();
    to.clear();
  }
  static std::string opening_of(int number) {
    return job_id_of("a test", static_cast<uint64_t>(number));
  }
  /// The number of the job of `side` x `side` pixels in tiles of 16, once it is accepted.
  /// `first_number`: that of the first frame in an animation; 0: the frames are of none.
  uint64_t submit(uint32_t seed, int priority = 0, int side = 32, uint32_t weight = 1,
                  int frames = 1, Time now = {}, int first_number = 0) {
    v1::Envelope message;
    v1::SubmitJob& request = *message.mutable_submit_job();
    request.set_submission(1000 + seed);
    request.set_detached(true);
    request.set_priority(priority);
    request.set_weight(weight);
    request.set_tile_size(16);
    request.mutable_crop()->set_x1(side);
    request.mutable_crop()->set_y1(side);
    request.set_animation(first_number != 0);
    BlobStore blobs;
    for (int i = 0; i < frames; ++i) {
      JobSpec spec = job(side);
      spec.frame.set_seed(seed + static_cast<uint32_t>(i) * 100);
      v1::JobFrame& frame = *request.add_frames();
      if (first_number != 0) frame.set_number(first_number + i);
      const std::string scene = serialize_scene(spec.scene);
      const auto bytes = std::as_bytes(std::span(scene));
      frame.set_scene_digest(blobs.put({bytes.begin(), bytes.end()}).hex());
      frame.set_scene_size(bytes.size());
      *frame.mutable_settings() = spec.frame;
    }
    submit_with(message, blobs, now);
    return heard(v1::Envelope::kJobStatus).back().job_status().job();
  }
  /// Of one frame, for a client that waits for it.
  static v1::Envelope submission(uint64_t number, const JobSpec& spec, BlobStore& blobs) {
    v1::Envelope message;
    v1::SubmitJob& request = *message.mutable_submit_job();
    request.set_submission(number);
    request.set_tile_size(16);
    request.mutable_crop()->set_x1(spec.crop.x1);
    request.mutable_crop()->set_y1(spec.crop.y1);
    const std::string scene = serialize_scene(spec.scene);
    const auto bytes = std::as_bytes(std::span(scene));
    v1::JobFrame& frame = *request.add_frames();
    frame.set_scene_digest(blobs.put({bytes.begin(), bytes.end()}).hex());
    frame.set_scene_size(bytes.size());
    *frame.mutable_settings() = spec.frame;
    return message;
  }
  /// Says it and sends what is asked for upon it.
  void submit_with(const v1::Envelope& message, const BlobStore& blobs, Time now = {}) {
    const size_t asked = heard(v1::Envelope::kBlobRequest).size();
    say("client", message, now);
    const auto requests = heard(v1::Envelope::kBlobRequest);
    for (size_t i = asked; i < requests.size(); ++i) {
      const auto& wanted = requests[i].blob_request();
      coordinator.on_message(
          Channel::bulk, "b",
          answer_blob_request(wanted, blobs.find(*Digest::parse(wanted.digest()))), {});
    }
  }
  v1::JobStatus ask(uint64_t id, v1::JobQuery::Action action = v1::JobQuery::ASK, Time now = {}) {
    v1::JobQuery query;
    query.set_job(id);
    query.set_action(action);
    return coordinator.ask(query, now);
  }
  /// A worker that has built all scenes that it is told of.
  void come(WorkerId id, uint32_t credit) {
    v1::Envelope message = hello(id);
    message.mutable_hello()->set_credit(credit);
    message.mutable_hello()->set_threads(credit);
    const PeerId peer = "w" + std::to_string(id);
    say(peer, message);
    get_ready(peer);
  }
  void get_ready(const PeerId& peer, Time now = {}) {
    for (size_t told = 0; told < heard(v1::Envelope::kJobStart).size(); ++told) {
      ready(peer, heard(v1::Envelope::kJobStart)[told].job_start().job(), now);
    }
  }
  std::vector<v1::Assign> assigned() {
    std::vector<v1::Assign> result;
    for (const auto& message : heard(v1::Envelope::kAssign)) result.push_back(message.assign());
    return result;
  }
  static uint64_t job_of(const v1::Assign& assign) { return assign.job() >> 20; }
  /// The number by which workers know the first frame of the job.
  static uint64_t first_frame_of(uint64_t id) { return (id << 20) + 1; }
  /// Of the job among the assignments from the `from`-th on.
  size_t count_of(uint64_t id, size_t from = 0) {
    const auto all_of_them = assigned();
    return static_cast<size_t>(
        std::count_if(all_of_them.begin() + static_cast<ptrdiff_t>(from), all_of_them.end(),
                      [id](const v1::Assign& assign) { return job_of(assign) == id; }));
  }

  int openings = 0;
  std::shared_ptr<MemoryJobStore> store = std::make_shared<MemoryJobStore>(7);
};

}  // namespace tessera::testing
