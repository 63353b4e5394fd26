#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/wire/scene_codec.h"
#include "tests/farm/fake_renderer.h"
#include "worker/worker_session.h"

namespace tessera {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class WorkerSessionTest : public ::testing::Test {
 protected:
  WorkerSessionTest() : session(options(), Time{0}) {
    scene.mutable_metadata()->set_title("x");
    const std::string bytes = serialize_scene(scene);
    const auto span = std::as_bytes(std::span(bytes));
    scene_digest = store.put({span.begin(), span.end()});
    scene_size = span.size();
  }

  static SessionOptions options() {
    SessionOptions options;
    options.hello.set_worker_id(5);
    options.hello.set_credit(2);
    options.orphan_timeout = seconds(30);
    return options;
  }
  /// Starts anew, as a worker that keeps blobs on disk.
  void begin_with_disk() {
    SessionOptions with_disk = options();
    with_disk.blob_sources.disk = true;
    session = WorkerSession(with_disk, Time{0});
  }

  /// What the session wants done since last asked, of one kind.
  template <typename Action>
  std::vector<Action> wants() {
    for (auto& action : session.take_actions()) actions.push_back(std::move(action));
    std::vector<Action> result;
    std::erase_if(actions, [&](SessionAction& action) {
      if (!std::holds_alternative<Action>(action)) return false;
      result.push_back(std::move(std::get<Action>(action)));
      return true;
    });
    return result;
  }

  /// Messages of one kind that it sent since last asked; others of that time are forgotten.
  std::vector<v1::Envelope> sent(v1::Envelope::MessageCase kind) {
    std::vector<v1::Envelope> result;
    for (auto& send : wants<SendMessage>()) {
      if (send.message.message_case() == kind) result.push_back(std::move(send.message));
    }
    return result;
  }

  /// Lets time pass as for a process that runs, until then or until the session wants to end.
  void run_until(Time time) {
    for (Time next; (next = session.next_deadline()) < time;) {
      session.on_tick(next);
      if (session.next_deadline() <= next) return;
    }
    session.on_tick(time);
  }

  void welcome(uint64_t number, Time now = {}, uint64_t farm = 1) {
    v1::Envelope message;
    v1::Welcome& welcome = *message.mutable_welcome();
    welcome.set_session(number);
    welcome.set_farm(farm);
    welcome.set_heartbeat_ms(1000);
    welcome.set_lost_after_ms(5000);
    welcome.set_bulk_endpoint("tcp://:9");
    session.on_message(Channel::control, message, now);
  }

  void start(uint64_t job, Time now = {}, uint32_t seed = 0) {
    v1::Envelope message;
    v1::JobStart& start = *message.mutable_job_start();
    start.set_job(job);
    start.set_scene_digest(scene_digest.hex());
    start.set_scene_size(scene_size);
    start.mutable_frame()->set_seed(seed);
    start.mutable_frame()->set_width(64);
    start.mutable_frame()->set_height(64);
    session.on_message(Channel::control, message, now);
  }

  void serve_blobs() {
    for (const auto& request : sent(v1::Envelope::kBlobRequest)) {
      const auto digest = Digest::parse(request.blob_request().digest());
      session.on_message(Channel::bulk,
                         answer_blob_request(request.blob_request(), store.find(*digest)), {});
    }
  }

  void built(uint64_t job) {
    session.on_built({.job = job,
                      .frame_id = {},
                      .renderer = std::make_shared<testing::FakeRenderer>(5),
                      .seconds = 1,
                      .failure = {}},
                     {});
  }

  void make_ready(uint64_t job) {
    welcome(1);
    start(job);
    serve_blobs();
    built(job);
    wants<SendMessage>();
    wants<StartBuild>();
  }

  void assign(uint64_t job, uint64_t lease, int x1 = 16) {
    v1::Envelope message;
    v1::Assign& assign = *message.mutable_assign();
    assign.set_job(job);
    assign.set_lease(lease);
    assign.mutable_rect()->set_x1(x1);
    assign.mutable_rect()->set_y1(16);
    assign.set_sample_count(1);
    session.on_message(Channel::control, message, {});
  }

  void ping(uint64_t results, Time now) {
    v1::Envelope message;
    message.mutable_ping()->set_session(1);
    message.mutable_ping()->set_results(results);
    session.on_message(Channel::control, message, now);
  }

  v1::Scene scene;
  BlobStore store;
  Digest scene_digest;
  uint64_t scene_size = 0;
  WorkerSession session;
  std::vector<SessionAction> actions;
};

}  // namespace tessera
