// The real loops over real sockets, and in memory, with workers on threads of this process.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <thread>

#include "client/farm_client.h"
#include "client/run_remote_job.h"
#include "coordinator/coordinator.h"
#include "coordinator/render_loop.h"
#include "proto/transport/memory_transport.h"
#include "proto/transport/zmq_transport.h"
#include "proto/wire/frame.h"
#include "tests/farm/fake_renderer.h"
#include "tests/farm/played_hello.h"
#include "tests/temporary_folder.h"
#include "worker/run_worker.h"

namespace tessera::testing {
namespace {

WorkerOptions worker_options(int threads) {
  WorkerOptions options;
  options.threads = threads;
  options.make_renderer = make_fake_renderer;
  return options;
}

/// Takes 30 ms for a tile.
class SlowRenderer : public FakeRenderer {
 public:
  using FakeRenderer::FakeRenderer;
  std::optional<TilePixels> render(const RenderTask& task, TileProgress& progress) const override {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    return FakeRenderer::render(task, progress);
  }
};

WorkerOptions slow_worker_options() {
  WorkerOptions options = worker_options(1);
  options.make_renderer = [](const v1::Scene&, const BlobStore&, const v1::FrameSettings& frame,
                             int) { return std::make_shared<SlowRenderer>(frame.seed()); };
  return options;
}

/// Workers on threads, each with its own connection.
class Threads {
 public:
  void add(std::unique_ptr<ClientTransport> transport, const WorkerOptions& options) {
    // Makes the logger here: who meets in its making cannot be seen by the thread sanitizer.
    spdlog::default_logger();
    transports_.push_back(std::move(transport));
    ends_.push_back(std::make_unique<WorkerEnd>());
    threads_.emplace_back([this, transport = transports_.back().get(), end = ends_.back().get(),
                           options] { *end = run_worker(*transport, options, stop_); });
  }
  ~Threads() { join(); }
  void join() {
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }
  void stop() { stop_ = true; }
  const WorkerEnd& end(size_t i) const { return *ends_[i]; }

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::unique_ptr<ClientTransport>> transports_;
  std::vector<std::unique_ptr<WorkerEnd>> ends_;
  std::vector<std::thread> threads_;
};

const std::atomic<bool> kNever{false};

TEST(RenderLoop, InMemoryWorkerTracesTheFrame) {
  MemoryNetwork network;
  RenderLoop loop(network.server(), {});
  Threads workers;
  workers.add(network.client(), worker_options(3));
  const JobSpec job = make_job(100, 60, 16);
  uint64_t told = 0;
  const JobResult result = loop.run(
      job, [&](const JobProgress& p) { told = p.tiles_total; }, kNever);
  loop.shut_down("done");
  EXPECT_EQ(result.report.end, JobReport::End::done);
  EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
  EXPECT_EQ(result.report.tiles_total, 28u);
  EXPECT_EQ(told, 28u);
  EXPECT_EQ(result.report.counters.at("rays_primary"), 100u * 60 * 4);
  EXPECT_EQ(result.report.build_counters.at("build_skipped"), 3u);
  workers.join();
  EXPECT_EQ(workers.end(0).exit_code, ExitCode::done);
}

TEST(RenderLoop, SocketWorkersGiveTheSameBitsForAnyCut) {
  for (const char* scheme : {"ipc", "tcp"}) {
    const TemporaryFolder folder;
    const std::string endpoint =
        scheme == std::string("ipc") ? "ipc://" + (folder / "farm") : "tcp://127.0.0.1:*";
    RenderLoop loop(bind_server(endpoint), {});
    Threads workers;
    for (int i = 0; i < 3; ++i) workers.add(connect_client(loop.endpoint()), worker_options(2));
    for (const int tile : {0, 8, 33, 1000}) {
      // Three chunks of one blob, the last of them short.
      JobSpec job = make_job(200, 150, tile, 2'500'000);
      job.crop = {13, 7, 181, 150};
      const JobResult result = loop.run(job, nullptr, kNever);
      EXPECT_EQ(result.report.end, JobReport::End::done);
      EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job)) << scheme << " tile " << tile;
      EXPECT_EQ(result.report.mismatches, 0u);
      EXPECT_EQ(result.report.counters.at("rays_primary"), 168u * 143 * 4);
    }
    loop.shut_down("done");
    workers.join();
  }
}

TEST(RenderLoop, CompressesPixelsThatLeaveTheMachine) {
  const TemporaryFolder folder;
  for (const std::string& endpoint :
       {"ipc://" + (folder / "farm"), std::string("tcp://127.0.0.1:*")}) {
    RenderLoop loop(bind_server(endpoint), {});
    Threads workers;
    workers.add(connect_client(loop.endpoint()), worker_options(1));
    const JobSpec job = make_job(200, 150, 50);
    const JobResult result = loop.run(job, nullptr, kNever);
    EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
    const uint64_t raw = 200 * 150 * kFilmChannels * sizeof(float);
    if (endpoint.starts_with("ipc://")) {
      EXPECT_EQ(result.report.bytes_results, raw);
    } else {
      EXPECT_LT(result.report.bytes_results, raw);
    }
    loop.shut_down("done");
    workers.join();
  }
}

TEST(RenderLoop, ServesAClientThatSubmitsAJob) {
  RenderLoop loop(bind_server("tcp://127.0.0.1:*"), {});
  std::atomic<bool> stop{false};
  std::thread server([&] { loop.serve(stop); });
  {
    Threads workers;
    workers.add(connect_client(loop.endpoint()), worker_options(2));
    for (int round = 0; round < 2; ++round) {
      const auto client = connect_client(loop.endpoint());
      JobSpec job = make_job(700, 400, 32, 2'500'000);
      job.frame.set_seed(static_cast<uint32_t>(round));
      const JobResult result = run_remote_job(*client, "memory", job, nullptr, kNever);
      EXPECT_EQ(result.report.end, JobReport::End::done);
      EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
      EXPECT_EQ(result.report.tiles_done, 22u * 13);
    }
    workers.stop();
  }
  stop = true;
  server.join();
}

TEST(RenderLoop, AClientThatWatchesIsToldEachPixelOnce) {
  RenderLoop loop(bind_server("tcp://127.0.0.1:*"), {});
  std::atomic<bool> stop{false};
  std::thread server([&] { loop.serve(stop); });
  {
    Threads workers;
    workers.add(connect_client(loop.endpoint()), slow_worker_options());
    const auto client = connect_client(loop.endpoint());
    const JobSpec job = make_job(150, 90, 16);
    Film seen(job.crop);
    std::vector<int> told(static_cast<size_t>(job.crop.area()));
    int calls = 0;
    const auto watch = [&](const NewTiles& news) {
      ++calls;
      for (const PixelRect& tile : news.tiles) {
        for (int y = tile.y0; y < tile.y1; ++y) {
          const auto first = static_cast<size_t>(y * seen.width() + tile.x0);
          seen.write(tile, y, 1, news.values.subspan(first * 3, size_t(tile.width()) * 3));
          for (size_t i = 0; i < size_t(tile.width()); ++i) ++told[first + i];
        }
      }
    };
    const JobResult result =
        run_remote_job(*client, "memory", job, nullptr, kNever, std::chrono::seconds(15), watch);
    EXPECT_EQ(result.report.end, JobReport::End::done);
    EXPECT_EQ(seen.pixels_sha256(), expected_sha256(job));
    EXPECT_EQ(std::count(told.begin(), told.end(), 1), job.crop.area());
    EXPECT_GT(calls, 2);
    workers.stop();
  }
  stop = true;
  server.join();
}

TEST(RenderLoop, AnotherCoordinatorAtTheSamePlaceGetsItsOwnPicture) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + (folder / "farm");
  Threads workers;
  JobSpec job = make_job(64, 64, 16);
  CoordinatorOptions options;
  options.heartbeat = std::chrono::milliseconds(50);
  {
    RenderLoop loop(bind_server(endpoint), options);
    workers.add(connect_client(endpoint), slow_worker_options());
    // As if it were killed in the middle of the job.
    struct Killed {};
    const auto kill = [](const JobProgress& progress) {
      if (progress.tiles_done > 0) throw Killed{};
    };
    EXPECT_THROW(loop.run(job, kill, kNever), Killed);
  }
  job.frame.set_seed(job.frame.seed() + 1);
  RenderLoop loop(bind_server(endpoint), options);
  const JobResult result = loop.run(job, nullptr, kNever);
  EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
  EXPECT_EQ(result.report.mismatches, 0u);
  loop.shut_down("done");
  workers.join();
}

/// Counts the tiles, and traces only the first one before it may go on.
class Noting : public FakeRenderer {
 public:
  Noting(uint32_t seed, std::atomic<int>& traced, const std::atomic<bool>& goes_on)
      : FakeRenderer(seed), traced_(traced), goes_on_(goes_on) {}
  std::optional<TilePixels> render(const RenderTask& task, TileProgress& p) const override {
    const bool is_first = begun_++ == 0;
    while (!is_first && !goes_on_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    auto pixels = FakeRenderer::render(task, p);
    if (pixels) ++traced_;
    return pixels;
  }

 private:
  std::atomic<int>& traced_;
  const std::atomic<bool>& goes_on_;
  mutable std::atomic<int> begun_{0};
};

TEST(RenderLoop, WhatAnOrphanTracedBeforeItEndedIsHandedInByTheNextProcess) {
  const TemporaryFolder folder;
  MemoryNetwork network;
  CoordinatorOptions options;
  options.heartbeat = std::chrono::milliseconds(50);
  options.lost_after = std::chrono::seconds(2);
  RenderLoop loop(network.server(), options);
  std::atomic<int> traced{0};
  std::atomic<bool> stands_still{false};
  WorkerOptions worker = worker_options(4);
  worker.spool_folder = folder.path();
  worker.make_renderer = [&](const v1::Scene&, const BlobStore&, const v1::FrameSettings& frame,
                             int) {
    return std::make_shared<Noting>(frame.seed(), traced, stands_still);
  };
  Threads second;
  auto first = std::make_unique<Threads>();
  first->add(network.client(), worker);
  const auto has_spooled = [&] { return !std::filesystem::is_empty(folder.path()); };
  const JobSpec job = make_job(64, 64, 16);
  int seen = 0;
  // The coordinator stands still in the middle of the job.
  const JobResult result = loop.run(
      job,
      [&](const JobProgress& progress) {
        if (!first || progress.tiles_done == 0) return;
        stands_still = true;
        // It holds six tiles at least.
        while (traced < 4) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        first->stop();
        first->join();
        first.reset();
        EXPECT_TRUE(has_spooled());
        seen = traced - static_cast<int>(progress.tiles_done);
        second.add(network.client(), worker);
      },
      kNever);
  loop.shut_down("done");
  second.join();
  EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
  EXPECT_GE(seen, 3);
  // Exactly 16, but where the machine is so slow that a worker is taken for lost.
  EXPECT_LT(traced, 16 + seen) << "none twice";
  EXPECT_EQ(result.report.tiles_done, 16u);
  EXPECT_FALSE(has_spooled());
}

TEST(RenderLoop, AClientThatIsInterruptedBeforeAnybodyAnswersEndsAtOnce) {
  const auto client = connect_client("tcp://127.0.0.1:1");
  const std::atomic<bool> stop{true};
  const JobResult result =
      run_remote_job(*client, "memory", make_job(8, 8, 8), nullptr, stop, std::chrono::hours(100));
  EXPECT_EQ(result.report.exit_code, ExitCode::interrupted);
  EXPECT_EQ(result.report.holes, std::vector<PixelRect>({{0, 0, 8, 8}}));
}

TEST(RenderLoop, StopLeavesWhatThereIs) {
  MemoryNetwork network;
  RenderLoop loop(network.server(), {});
  const std::atomic<bool> stop{true};
  const JobResult result = loop.run(make_job(64, 64, 16), nullptr, stop);
  EXPECT_EQ(result.report.end, JobReport::End::interrupted);
  EXPECT_EQ(result.report.exit_code, ExitCode::interrupted);
  EXPECT_EQ(result.report.holes.size(), 16u);
}

TEST(RenderLoop, RefusesAWorkerOfAnotherVersionAndNamesBoth) {
  MemoryNetwork network;
  RenderLoop loop(network.server(), {});
  Threads strangers, workers;
  WorkerOptions strange = worker_options(1);
  strange.protocol_major = 77;
  strangers.add(network.client(), strange);
  strange = worker_options(1);
  strange.numerics_id = "x87";
  strangers.add(network.client(), strange);
  workers.add(network.client(), worker_options(1));
  const JobSpec job = make_job(64, 64, 16);
  EXPECT_EQ(loop.run(job, nullptr, kNever).film.pixels_sha256(), expected_sha256(job));
  std::atomic<bool> stop{false};
  std::thread server([&] { loop.serve(stop); });
  // They end by themselves, as soon as they are refused.
  strangers.join();
  workers.stop();
  workers.join();
  stop = true;
  server.join();
  EXPECT_EQ(strangers.end(0).exit_code, ExitCode::bad_usage);
  EXPECT_THAT(strangers.end(0).reason, ::testing::HasSubstr("speaks protocol 77"));
  EXPECT_THAT(strangers.end(0).reason,
              ::testing::HasSubstr(fmt::format("expected {}", kProtocolMajor)));
  EXPECT_EQ(strangers.end(1).exit_code, ExitCode::bad_usage);
  EXPECT_THAT(strangers.end(1).reason, ::testing::HasSubstr("'x87'"));
}

TEST(RenderLoop, ASceneThatCannotBeBuiltFailsTheJob) {
  MemoryNetwork network;
  RenderLoop loop(network.server(), {});
  Threads workers;
  WorkerOptions options = worker_options(1);
  options.make_renderer = [](auto&&...) -> std::shared_ptr<const TileRenderer> {
    throw scene_error("no such material");
  };
  workers.add(network.client(), options);
  const JobResult result = loop.run(make_job(64, 64, 16), nullptr, kNever);
  loop.shut_down("done");
  EXPECT_EQ(result.report.end, JobReport::End::failed);
  EXPECT_EQ(result.report.exit_code, ExitCode::bad_scene);
  EXPECT_EQ(result.report.failure, "no such material");
}

TEST(RenderLoop, ATileThatAlwaysFailsIsNamedAndTheRestIsRendered) {
  class Poisoned : public FakeRenderer {
   public:
    using FakeRenderer::FakeRenderer;
    std::optional<TilePixels> render(const RenderTask& task, TileProgress& p) const override {
      if (task.rect.x0 == 16 && task.rect.y0 == 32) throw std::runtime_error("tile is cursed");
      return FakeRenderer::render(task, p);
    }
  };
  for (const int count : {1, 4}) {
    MemoryNetwork network;
    RenderLoop loop(network.server(), {});
    Threads workers;
    WorkerOptions options = worker_options(2);
    options.make_renderer = [](auto&&...) { return std::make_shared<Poisoned>(5); };
    for (int i = 0; i < count; ++i) workers.add(network.client(), options);
    const JobResult result = loop.run(make_job(64, 64, 16), nullptr, kNever);
    loop.shut_down("done");
    EXPECT_EQ(result.report.exit_code, ExitCode::render_failed);
    EXPECT_EQ(result.report.tiles_done, 15u);
    ASSERT_EQ(result.report.holes.size(), 1u);
    EXPECT_EQ(result.report.holes[0], (PixelRect{16, 32, 32, 48}));
    EXPECT_THAT(result.report.failure, ::testing::HasSubstr("16,32"));
    EXPECT_THAT(result.report.failure, ::testing::HasSubstr("tile is cursed"));
  }
}

/// A server that tells of a bulk port at which nobody is.
class Misleading : public ServerTransport {
 public:
  explicit Misleading(std::unique_ptr<ServerTransport> real) : real_(std::move(real)) {}
  std::string endpoint() const override { return real_->endpoint(); }
  std::string bulk_endpoint() const override { return "tcp://:1"; }
  void wait(std::chrono::milliseconds timeout) override { real_->wait(timeout); }
  std::optional<ReceivedMessage> receive() override { return real_->receive(); }
  SendResult send(Channel channel, const PeerId& peer, MessageBytes bytes) override {
    return real_->send(channel, peer, std::move(bytes));
  }
  void wake() override { real_->wake(); }

 private:
  std::unique_ptr<ServerTransport> real_;
};

TEST(RenderLoop, AClientWhoseBulkLineStaysAwayIsToldAndDoesNotWaitForEver) {
  // The coordinator speaks all the while, by the other line.
  RenderLoop loop(std::make_unique<Misleading>(bind_server("tcp://127.0.0.1:*")), {});
  std::atomic<bool> stop{false};
  std::thread server([&] { loop.serve(stop); });
  const JobSpec job = make_job(64, 64, 16);
  constexpr std::chrono::seconds kPatience{2};
  const auto expect_told = [](const std::function<void()>& act) {
    try {
      act();
      ADD_FAILURE() << "it came through";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::render_failed);
      EXPECT_THAT(error.what(), ::testing::HasSubstr("tcp://127.0.0.1:1, which does not answer"));
    }
  };
  std::thread submits([&] {
    const auto transport = connect_client(loop.endpoint());
    FarmClient client(*transport, loop.endpoint(), kNever, kPatience);
    SubmittedJob submitted;
    add_frame(submitted, job);
    submitted.request.set_submission(draw_submission());
    expect_told([&] { client.submit(submitted); });
  });
  const auto transport = connect_client(loop.endpoint());
  expect_told(
      [&] { run_remote_job(*transport, loop.endpoint(), job, nullptr, kNever, kPatience); });
  submits.join();
  stop = true;
  server.join();
}

/// A client whose line brings every message twice.
class Doubling : public ClientTransport {
 public:
  explicit Doubling(std::unique_ptr<ClientTransport> real) : real_(std::move(real)) {}
  void connect_bulk(const std::string& endpoint) override { real_->connect_bulk(endpoint); }
  void wait(std::chrono::milliseconds timeout) override { real_->wait(timeout); }
  std::optional<ReceivedMessage> receive() override {
    if (again_) return std::exchange(again_, std::nullopt);
    return again_ = real_->receive();
  }
  void send(Channel channel, MessageBytes bytes) override {
    real_->send(channel, std::move(bytes));
  }
  void reconnect() override { real_->reconnect(); }
  void wake() override { real_->wake(); }

 private:
  std::unique_ptr<ClientTransport> real_;
  std::optional<ReceivedMessage> again_;
};

TEST(RenderLoop, AClientToldTwiceOfAJobListsItOnce) {
  RenderLoop loop(bind_server("tcp://127.0.0.1:*"), {});
  std::atomic<bool> stop{false};
  std::thread server([&] { loop.serve(stop); });
  Doubling transport(connect_client(loop.endpoint()));
  FarmClient client(transport, loop.endpoint(), kNever);
  for (int i = 0; i < 2; ++i) {
    SubmittedJob submitted;
    add_frame(submitted, make_job(64, 64, 16));
    submitted.request.set_submission(draw_submission());
    submitted.request.set_detached(true);
    client.submit(submitted);
  }
  EXPECT_EQ(client.list().jobs_size(), 2);
  stop = true;
  server.join();
}

/// Counts the waits of a transport, none of which ends by itself.
class PatientTransport : public ServerTransport {
 public:
  PatientTransport(std::unique_ptr<ServerTransport> inner, std::atomic<int>& waits)
      : inner_(std::move(inner)), waits_(waits) {}
  std::string endpoint() const override { return inner_->endpoint(); }
  std::string bulk_endpoint() const override { return inner_->bulk_endpoint(); }
  void wait(std::chrono::milliseconds) override {
    ++waits_;
    inner_->wait(std::chrono::hours(1));
  }
  std::optional<ReceivedMessage> receive() override { return inner_->receive(); }
  SendResult send(Channel channel, const PeerId& peer, MessageBytes bytes) override {
    return inner_->send(channel, peer, std::move(bytes));
  }
  void wake() override { inner_->wake(); }

 private:
  std::unique_ptr<ServerTransport> inner_;
  std::atomic<int>& waits_;
};

TEST(RenderLoop, AnOrderFromAnotherThreadIsHeardAndDeliveredInOneRound) {
  MemoryNetwork network;
  std::atomic<int> waits{0}, looks{0};
  RenderLoop loop(std::make_unique<PatientTransport>(network.server(), waits), {});
  std::atomic<bool> stop{false}, ordered{false};
  std::atomic<uint64_t> job{0};
  JobSpec spec = make_job(32, 32, 16);
  loop.observe(
      [&](Coordinator& coordinator, Time now) {
        ++looks;
        if (ordered.exchange(false)) job = coordinator.submit(spec, now);
      },
      std::chrono::hours(1));
  // It says hello, and then nothing: no message of its own wakes the loop.
  const auto worker = network.client();
  std::thread server([&] { loop.serve(stop); });
  const auto receive = [&](auto has) {
    while (true) {
      worker->wait(std::chrono::hours(1));
      while (const auto received = worker->receive()) {
        const auto message = decode(received->bytes, kMaxFrame);
        if (message && has(*message)) return *message;
      }
    }
  };
  worker->send(Channel::control, encode(played_hello(1)));
  receive([](const v1::Envelope& message) { return message.has_welcome(); });
  while (waits < 2 || looks < 1) std::this_thread::yield();
  const int waits_before = waits, looks_before = looks;
  ordered = true;
  loop.wake();
  const auto start = receive([](const v1::Envelope& message) { return message.has_job_start(); });
  EXPECT_EQ(start.job_start().job(), job);
  EXPECT_EQ(looks, looks_before + 1);
  EXPECT_LE(waits, waits_before + 1) << "the message left in the round of the order";
  stop = true;
  loop.wake();
  server.join();
}

TEST(RenderLoop, NobodyAnswersAClient) {
  const auto client = connect_client("tcp://127.0.0.1:1");
  EXPECT_THROW(run_remote_job(*client, "memory", make_job(8, 8, 8), nullptr, kNever,
                              std::chrono::milliseconds(200)),
               Error);
}

TEST(FarmClientTest, TakesNoAnswerToAnEarlierQuestionForThisOne) {
  MemoryNetwork network;
  const auto server = network.server();
  const auto transport = network.client();
  constexpr std::atomic<bool> kNotStopped{false};
  v1::JobStatus cancelled, forgotten;
  std::thread asker([&] {
    FarmClient client(*transport, "a farm", kNotStopped);
    v1::JobQuery query;
    query.set_job(7);
    query.set_action(v1::JobQuery::CANCEL);
    cancelled = client.ask(query);
    query.set_action(v1::JobQuery::FORGET);
    forgotten = client.ask(query);
  });
  v1::Envelope first;
  first.mutable_job_status()->set_job(7);
  first.mutable_job_status()->set_state(v1::JobStatus::ENDED);
  for (bool ended = false; !ended;) {
    server->wait(std::chrono::milliseconds(10));
    while (const auto received = server->receive()) {
      const auto message = decode(received->bytes, kMaxFrame);
      ASSERT_TRUE(message && message->has_job_query());
      ended = message->job_query().action() == v1::JobQuery::FORGET;
      v1::Envelope answer;
      answer.mutable_job_status()->set_job(7);
      answer.mutable_job_status()->set_question(message->job_query().question());
      if (!ended) *first.mutable_job_status() = answer.job_status();
      first.mutable_job_status()->set_state(v1::JobStatus::ENDED);
      // The question before was asked twice, and is answered twice.
      server->send(Channel::control, received->peer, encode(first));
      if (ended) server->send(Channel::control, received->peer, encode(answer));
    }
  }
  asker.join();
  EXPECT_EQ(cancelled.state(), v1::JobStatus::ENDED);
  EXPECT_EQ(forgotten.state(), v1::JobStatus::UNKNOWN);
}

}  // namespace
}  // namespace tessera::testing
