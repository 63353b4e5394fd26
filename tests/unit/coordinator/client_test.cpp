// What clients and the coordinator say to each other.
#include "coordinator/jobs/memory_job_store.h"
#include "coordinator/submission.h"
#include "proto/wire/blob_transfer.h"
#include "proto/wire/scene_codec.h"
#include "tests/unit/coordinator/coordinator_fixture.h"

namespace tessera::testing {
namespace {

class ClientTest : public CoordinatorTest {
 protected:
  v1::Envelope submission(uint64_t number, const JobSpec& spec) {
    v1::Envelope message;
    v1::SubmitJob& submit = *message.mutable_submit_job();
    submit.set_submission(number);
    const std::string bytes = serialize_scene(spec.scene);
    const auto span = std::as_bytes(std::span(bytes));
    v1::JobFrame& frame = *submit.add_frames();
    frame.set_scene_digest(store.put({span.begin(), span.end()}).hex());
    frame.set_scene_size(bytes.size());
    *frame.mutable_settings() = spec.frame;
    submit.mutable_crop()->set_x1(spec.crop.x1);
    submit.mutable_crop()->set_y1(spec.crop.y1);
    return message;
  }
  /// The answers to all that was asked of clients.
  std::vector<v1::Envelope> chunks() {
    std::vector<v1::Envelope> result;
    for (const auto& message : heard(v1::Envelope::kBlobRequest)) {
      const auto& request = message.blob_request();
      result.push_back(answer_blob_request(request, store.find(*Digest::parse(request.digest()))));
    }
    return result;
  }
  v1::JobStatus status() { return heard(v1::Envelope::kJobStatus).back().job_status(); }
  v1::JobStatus ask(uint64_t number, bool cancel) {
    v1::Envelope message;
    message.mutable_job_query()->set_submission(number);
    if (cancel) message.mutable_job_query()->set_action(v1::JobQuery::CANCEL);
    say("client", message);
    return status();
  }
  BlobStore store;
};

TEST_F(ClientTest, CancelsAJobAtOnceAlsoWhereItWasNotBegun) {
  say("client", submission(41, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  EXPECT_EQ(ask(41, false).state(), v1::JobStatus::RUNNING);
  EXPECT_EQ(ask(41, true).state(), v1::JobStatus::ENDED);
  for (int i = 0; i < 8; ++i) coordinator.submit(job(), {});
  say("client", submission(42, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  EXPECT_EQ(ask(42, false).state(), v1::JobStatus::QUEUED);
  const v1::JobStatus cancelled = ask(42, true);
  EXPECT_EQ(cancelled.state(), v1::JobStatus::ENDED);
  EXPECT_EQ(cancelled.end().how(), v1::JobEnd::INTERRUPTED);
  EXPECT_EQ(cancelled.end().film_digest(), "") << "no picture is made of no tile";
}

TEST_F(ClientTest, AreNotGoneBecauseTheCoordinatorWasStopped) {
  coordinator.on_tick({});
  say("client", submission(41, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  EXPECT_EQ(ask(41, false).state(), v1::JobStatus::RUNNING);
  Time now = seconds(65);
  coordinator.on_tick(now);
  EXPECT_NE(ask(41, false).state(), v1::JobStatus::UNKNOWN) << "its questions may wait to be read";
}

TEST_F(ClientTest, HaveFewScenesReadAtOneGoByTheirBytes) {
  MemoryJobStore scenes;
  v1::SubmitJob request;
  request.set_submission(42);
  for (int i = 0; i < 5; ++i) {
    v1::Scene scene;
    scene.mutable_metadata()->set_notes(std::string(size_t{3} << 20, static_cast<char>('a' + i)));
    const std::string text = serialize_scene(scene);
    const auto bytes = std::as_bytes(std::span(text));
    const Digest digest = Digest::of(bytes);
    scenes.put_blob(digest, copy_to_blob(bytes));
    v1::JobFrame& frame = *request.add_frames();
    frame.set_scene_digest(digest.hex());
    frame.set_scene_size(bytes.size());
  }
  Submission submission(request, scenes, {});
  int calls = 0;
  while (!submission.finished() && calls < 10) {
    submission.advance(scenes, {});
    ++calls;
  }
  EXPECT_EQ(calls, 3) << "no more begun after 4 MiB";
}

TEST_F(ClientTest, AreAskedAnewForWhatWasForgottenMeanwhile) {
  MemoryJobStore kept;
  const auto digest_of = [](std::string_view text) {
    return Digest::of(std::as_bytes(std::span(text)));
  };
  const auto put = [&](std::string_view text) {
    kept.put_blob(digest_of(text), copy_to_blob(std::as_bytes(std::span(text))));
  };
  put("shared");
  v1::Scene scene;
  for (const char* name : {"shared", "own"}) {
    v1::BlobRef& blob = *scene.add_nodes()->mutable_shape()->mutable_mesh()->mutable_positions();
    blob.set_digest(digest_of(name).hex());
    blob.set_size(std::string_view(name).size());
  }
  const std::string text = serialize_scene(scene);
  put(text);
  v1::SubmitJob request;
  request.set_submission(42);
  v1::JobFrame& frame = *request.add_frames();
  frame.set_scene_digest(digest_of(text).hex());
  frame.set_scene_size(text.size());
  Submission submission(request, kept, {});
  ASSERT_EQ(submission.advance(kept, {}).size(), 1u) << "for its own blob alone";
  // Another job that has it, and the scene, is forgotten.
  kept.remove(1, {}, {digest_of("shared"), digest_of(text)});
  const auto bring = [&](std::string_view bytes) {
    v1::BlobChunk chunk;
    chunk.set_submission(42);
    chunk.set_digest(digest_of(bytes).hex());
    chunk.set_data(std::string(bytes));
    submission.on_chunk(chunk);
    return submission.advance(kept, {}).size();
  };
  EXPECT_EQ(bring("own"), 2u) << "for what is gone";
  EXPECT_FALSE(submission.finished());
  bring("shared");
  bring(text);
  EXPECT_TRUE(submission.finished());
  for (const Digest& digest : submission.blobs()) EXPECT_TRUE(kept.has_blob(digest));
}

TEST_F(ClientTest, AreToldWhyTheirJobsDoNotEnd) {
  say("client", submission(42, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  ASSERT_EQ(ask(42, false).state(), v1::JobStatus::RUNNING);
  coordinator.shut_down("told to end");
  const v1::JobStatus last = status();
  EXPECT_EQ(last.state(), v1::JobStatus::ENDED);
  EXPECT_EQ(last.end().how(), v1::JobEnd::FAILED);
  EXPECT_EQ(last.end().failure(), "told to end");
}

TEST_F(ClientTest, TakesBlobsOnlyFromWhoWasAsked) {
  say("client", submission(42, job()));
  const auto sound = chunks();
  ASSERT_FALSE(sound.empty());
  for (const uint64_t guess : {0, 41}) {
    v1::Envelope forged = sound[0];
    forged.mutable_blob_chunk()->set_submission(guess);
    forged.mutable_blob_chunk()->set_data("x");
    for (int i = 0; i < 5; ++i) coordinator.on_message(Channel::bulk, "evil", forged, {});
    forged.mutable_blob_missing()->set_digest(sound[0].blob_chunk().digest());
    forged.mutable_blob_missing()->set_submission(guess);
    coordinator.on_message(Channel::bulk, "evil", forged, {});
  }
  EXPECT_EQ(ask(42, false).state(), v1::JobStatus::FETCHING);
  for (const auto& chunk : sound) coordinator.on_message(Channel::bulk, "b", chunk, {});
  EXPECT_EQ(ask(42, false).state(), v1::JobStatus::RUNNING);
}

TEST_F(ClientTest, WhoLooksKeepsNoJobAlive) {
  say("client", submission(42, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  ASSERT_EQ(ask(42, false).state(), v1::JobStatus::RUNNING);
  v1::Envelope list;
  list.mutable_job_list_query();
  const AllowedKey viewer{Role::viewer, "eve", "k"};
  say("viewer", list, {}, viewer);
  const v1::JobList jobs = heard(v1::Envelope::kJobList).back().job_list();
  ASSERT_EQ(jobs.jobs_size(), 1);
  EXPECT_EQ(jobs.jobs(0).submission(), 0u) << "its client's alone";
  v1::Envelope query;
  query.mutable_job_query()->set_submission(42);
  const auto runs_at = [&](Time now) {
    for (Time next; (next = coordinator.next_deadline()) < now;) coordinator.on_tick(next);
    coordinator.on_tick(now);
    v1::JobQuery by_number;
    by_number.set_job(jobs.jobs(0).job());
    return coordinator.ask(by_number, now).state() == v1::JobStatus::RUNNING;
  };
  say("viewer", query, seconds(14), viewer);
  EXPECT_EQ(status().state(), v1::JobStatus::RUNNING) << "it is answered";
  EXPECT_TRUE(runs_at(seconds(14)));
  EXPECT_FALSE(runs_at(seconds(16)));
}

TEST_F(ClientTest, WhoMaySubmitKeepsItsJobAlive) {
  say("client", submission(42, job()));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  v1::Envelope query;
  query.mutable_job_query()->set_submission(42);
  say("client", query, seconds(14), {Role::submitter, "alice", "k"});
  coordinator.on_tick(seconds(16));
  EXPECT_EQ(ask(42, false).state(), v1::JobStatus::RUNNING);
}

TEST_F(ClientTest, AreHeldToABudgetTogether) {
  const auto submit = [this](uint64_t number, uint64_t bytes) {
    v1::Envelope message = submission(number, job());
    v1::JobFrame& frame = *message.mutable_submit_job()->add_frames();
    frame.set_scene_digest(Digest::of(std::to_string(number)).hex());
    frame.set_scene_size(bytes);
    say("client", message);
    return status();
  };
  EXPECT_EQ(submit(1, uint64_t{16} << 30).state(), v1::JobStatus::FETCHING);
  EXPECT_EQ(submit(2, uint64_t{15} << 30).state(), v1::JobStatus::FETCHING);
  EXPECT_EQ(submit(3, uint64_t{2} << 30).state(), v1::JobStatus::ENDED);
  EXPECT_EQ(submit(4, ~uint64_t{0}).state(), v1::JobStatus::ENDED);
  EXPECT_EQ(ask(1, true).state(), v1::JobStatus::ENDED);
  v1::Envelope release;
  release.mutable_job_release()->set_submission(1);
  say("client", release);
  EXPECT_EQ(submit(5, uint64_t{2} << 30).state(), v1::JobStatus::FETCHING) << "there is room again";
  EXPECT_EQ(submit(0, 1).state(), v1::JobStatus::ENDED) << "no number";
}

TEST_F(ClientTest, FilmDownloadsAreNoBytesOfTheSceneOfTheNextJob) {
  say("client", submission(42, job(16)));
  for (const auto& chunk : chunks()) coordinator.on_message(Channel::bulk, "b", chunk, {});
  say("p", hello(1));
  ready("p", job_id());
  say("p", band(heard(v1::Envelope::kAssign).at(0).assign(), 1));
  const uint64_t next = coordinator.submit(job(), {});
  const v1::JobStatus ended = ask(42, false);
  ASSERT_EQ(ended.end().film_size(), 16u * 16 * 12);
  v1::Envelope request;
  request.mutable_blob_request()->set_digest(ended.end().film_digest());
  request.mutable_blob_request()->set_length(1 << 20);
  coordinator.on_message(Channel::bulk, "b", request, {});
  EXPECT_EQ(heard(v1::Envelope::kBlobChunk).at(0).blob_chunk().data().size(), 16u * 16 * 12);
  coordinator.interrupt(next, {});
  EXPECT_EQ(coordinator.take_result(next)->report.bytes_scene, 0u);
}

}  // namespace
}  // namespace tessera::testing
