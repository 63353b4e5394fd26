// Real worker processes, and what can happen to them.
#include "coordinator/local_workers.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "base/error.h"
#include "base/program_folder.h"
#include "coordinator/render_loop.h"
#include "proto/transport/zmq_transport.h"
#include "tests/farm/fake_renderer.h"
#include "tests/temporary_folder.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;

const std::atomic<bool> kNever{false};

/// The program that plays workers, beside this one.
std::string fake_worker() { return program_folder() / "farm_fake_worker"; }

LocalWorkerOptions fake_workers(int count, int pause_ms) {
  LocalWorkerOptions options;
  options.count = count;
  options.program = fake_worker();
  options.extra_arguments = {"--pause", std::to_string(pause_ms)};
  return options;
}

bool alive(pid_t process) { return kill(process, 0) == 0; }

/// A coordinator with local workers, which rendering gives a `tick` every 100 ms.
struct Farm {
  LocalWorkers workers;
  RenderLoop loop;
  explicit Farm(const LocalWorkerOptions& options, const CoordinatorOptions& times = {})
      : workers(options), loop(bind_server(workers.endpoint()), times) {
    loop.watch(&workers);
    workers.start();
  }
  JobResult render(const JobSpec& job, const ProgressCallback& tick) {
    return loop.run(job, tick, kNever);
  }
};

TEST(LocalWorkers, RenderAndLeaveNothingBehind) {
  std::vector<pid_t> processes;
  std::string folder;
  {
    Farm farm(fake_workers(4, 0));
    processes = farm.workers.processes();
    folder = std::filesystem::path(farm.workers.endpoint().substr(6)).parent_path();
    EXPECT_EQ(std::filesystem::status(folder).permissions(), std::filesystem::perms::owner_all);
    const JobSpec job = make_job(200, 100, 16);
    const JobResult result = farm.render(job, nullptr);
    EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
    EXPECT_EQ(result.report.workers_lost, 0u);
    farm.loop.shut_down("done");
    farm.workers.stop(std::chrono::seconds(2));
    EXPECT_THAT(farm.workers.processes(), ::testing::IsEmpty());
  }
  for (const pid_t process : processes) EXPECT_FALSE(alive(process));
  EXPECT_FALSE(std::filesystem::exists(folder));
}

/// Whether all threads of the process have that nice level.
bool has_nice_level(pid_t process, int level) {
  for (const auto& thread :
       std::filesystem::directory_iterator(fmt::format("/proc/{}/task", process))) {
    const auto id = static_cast<id_t>(std::stoul(thread.path().filename().string()));
    if (getpriority(PRIO_PROCESS, id) != level) return false;
  }
  return true;
}

TEST(LocalWorkers, WorkAtTheirNiceLevel) {
  const int ours = getpriority(PRIO_PROCESS, 0);
  for (const int nice : {0, 7}) {
    LocalWorkerOptions options = fake_workers(2, 0);
    options.nice = nice;
    Farm farm(options);
    const JobSpec job = make_job(200, 100, 16);
    EXPECT_EQ(farm.render(job, nullptr).film.pixels_sha256(), expected_sha256(job));
    // One of the two may have begun too late to trace a tile.
    for (const pid_t process : farm.workers.processes()) {
      int looks = 0;
      while (!has_nice_level(process, std::min(ours + nice, 19)) && ++looks < 10'000) usleep(1000);
      EXPECT_LT(looks, 10'000);
    }
    farm.loop.shut_down("done");
  }
}

/// A job with four workers, the first of which lies in every tile.
JobResult render_with_a_liar(double verify, const JobSpec& job) {
  const TemporaryFolder folder;
  LocalWorkerOptions workers = fake_workers(4, 2);
  workers.extra_arguments.insert(workers.extra_arguments.end(), {"--lie-once", folder / "liar"});
  CoordinatorOptions options;
  options.verify = verify;
  options.verify_key = 11;
  Farm farm(workers, options);
  JobResult result = farm.render(job, nullptr);
  return result;
}

TEST(LocalWorkers, OneThatLiesIsSetAsideAndItsTilesAreTracedAgain) {
  const JobSpec job = make_job(200, 100, 16);
  for (const double share : {1.0, 0.3}) {
    const JobResult result = render_with_a_liar(share, job);
    EXPECT_EQ(result.report.end, JobReport::End::done) << result.report.failure;
    EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
    EXPECT_EQ(result.report.liars, 1u);
    EXPECT_GE(result.report.mismatches, 1u);
    EXPECT_GE(result.report.verified, share < 1 ? 10u : 80u);
    EXPECT_EQ(result.report.unverified, 0u);
  }
}

TEST(LocalWorkers, OneThatLiesAmongTwoFailsTheJobAndBothAreNamed) {
  const TemporaryFolder folder;
  LocalWorkerOptions workers = fake_workers(2, 2);
  workers.extra_arguments.insert(workers.extra_arguments.end(), {"--lie-once", folder / "liar"});
  CoordinatorOptions options;
  options.verify = 1;
  options.lease = std::chrono::seconds(2);
  Farm farm(workers, options);
  const JobResult result = farm.render(make_job(100, 60, 16), nullptr);
  EXPECT_EQ(result.report.end, JobReport::End::failed);
  EXPECT_THAT(result.report.failure, ::testing::HasSubstr("there is no third to decide"));
}

TEST(LocalWorkers, OneStoppedBeforeItsHelloIsReplaced) {
  const TemporaryFolder folder;
  LocalWorkerOptions options = fake_workers(1, 0);
  options.extra_arguments.insert(options.extra_arguments.end(), {"--stop-once", folder / "mark"});
  CoordinatorOptions times;
  times.greeting = milliseconds(2000);  // the one in its place says hello in time
  {
    Farm farm(options, times);
    const JobSpec job = make_job(64, 64, 16);
    const JobResult result = farm.render(job, nullptr);
    EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
    EXPECT_TRUE(std::filesystem::exists(folder / "mark"));
    farm.loop.shut_down("done");
  }
}

TEST(LocalWorkers, ThoseThatNeverSayHelloEndTheJob) {
  const TemporaryFolder folder;
  LocalWorkerOptions options = fake_workers(2, 0);
  options.extra_arguments.insert(options.extra_arguments.end(), {"--stop-always", "1"});
  CoordinatorOptions times;
  times.greeting = milliseconds(100);
  Farm farm(options, times);
  const JobResult result = farm.render(make_job(64, 64, 16), nullptr);
  EXPECT_EQ(result.report.end, JobReport::End::failed);
  EXPECT_THAT(result.report.failure,
              ::testing::HasSubstr("worker processes say nothing after they are started"));
  EXPECT_EQ(result.report.workers_lost, 0u);
}

TEST(LocalWorkers, KilledOnesAreReplacedAndThePictureIsTheSame) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    Farm farm(fake_workers(3, 20));
    const JobSpec job = make_job(160, 160, 16);
    int kills = 0;
    const JobResult result = farm.render(job, [&](const JobProgress& progress) {
      // A worker that has tiles: all are connected and the first results are in.
      if (kills >= 4 || progress.workers < 3 || progress.tiles_done == 0) return;
      if (progress.tiles_done == progress.tiles_total) return;
      const auto& running = farm.workers.processes();
      // The fourth time, all of them.
      if (++kills == 4) {
        for (const pid_t process : running) kill(process, SIGKILL);
      } else {
        kill(running[random() % running.size()], SIGKILL);
      }
    });
    EXPECT_EQ(result.report.end, JobReport::End::done) << result.report.failure << " seed " << seed;
    EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job)) << "seed " << seed;
    EXPECT_GE(result.report.workers_lost, 1u) << "seed " << seed;
    EXPECT_GE(result.report.retries, 1u) << "seed " << seed;
    EXPECT_EQ(result.report.mismatches, 0u);
  }
}

TEST(LocalWorkers, AStoppedOneHoldsNothingUpAndIsEnded) {
  pid_t stopped = 0;
  {
    Farm farm(fake_workers(3, 10));
    const JobSpec job = make_job(160, 160, 16);
    const JobResult result = farm.render(job, [&](const JobProgress& progress) {
      if (stopped != 0 || progress.tiles_done == 0) return;
      stopped = farm.workers.processes()[1];
      kill(stopped, SIGSTOP);
    });
    EXPECT_NE(stopped, 0);
    EXPECT_EQ(result.report.end, JobReport::End::done);
    EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
    farm.loop.shut_down("done");
    farm.workers.stop(milliseconds(100));
  }
  EXPECT_FALSE(alive(stopped));
}

TEST(LocalWorkers, WhenAllAreStoppedTheyAreReplaced) {
  CoordinatorOptions times;
  times.heartbeat = milliseconds(100);
  times.suspect_after = milliseconds(300);
  times.lost_after = milliseconds(500);
  Farm farm(fake_workers(2, 10), times);
  const JobSpec job = make_job(160, 160, 16);
  std::vector<pid_t> stopped;
  const JobResult result = farm.render(job, [&](const JobProgress& progress) {
    if (!stopped.empty() || progress.tiles_done == 0) return;
    stopped = farm.workers.processes();
    for (const pid_t process : stopped) kill(process, SIGSTOP);
  });
  EXPECT_EQ(stopped.size(), 2u);
  EXPECT_EQ(result.report.end, JobReport::End::done);
  EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
  EXPECT_GE(result.report.workers_lost, 2u);
  farm.workers.stop(Time{0});  // one that had not said hello before it was stopped is not missed
  for (const pid_t process : stopped) EXPECT_FALSE(alive(process));
}

TEST(LocalWorkers, AreReplacedAndEndedWhereSigchldIsIgnored) {
  const auto before = signal(SIGCHLD, SIG_IGN);
  {
    Farm farm(fake_workers(2, 10));
    const JobSpec job = make_job(96, 96, 16);
    pid_t killed = 0;
    const JobResult result = farm.render(job, [&](const JobProgress& progress) {
      if (killed != 0 || progress.tiles_done == 0) return;
      killed = farm.workers.processes()[0];
      kill(killed, SIGKILL);
    });
    EXPECT_NE(killed, 0);
    EXPECT_EQ(result.film.pixels_sha256(), expected_sha256(job));
    farm.workers.stop(milliseconds(100));
    EXPECT_THAT(farm.workers.processes(), ::testing::IsEmpty());
  }
  signal(SIGCHLD, before);
}

TEST(LocalWorkers, ATileThatCrashesThreeIsGivenUpAndTheRestIsRendered) {
  LocalWorkerOptions options = fake_workers(2, 2);
  options.extra_arguments.insert(options.extra_arguments.end(), {"--deadly", "yes"});
  Farm farm(options);
  const JobResult result = farm.render(make_job(96, 96, 16), nullptr);
  EXPECT_EQ(result.report.exit_code, ExitCode::render_failed);
  EXPECT_EQ(result.report.holes, std::vector<PixelRect>({{0, 0, 16, 16}}));
  EXPECT_EQ(result.report.tiles_done, 35u);
}

TEST(LocalWorkers, ASceneThatCrashesTwoThatBuildItFailsTheJob) {
  for (const int count : {1, 3}) {
    LocalWorkerOptions options = fake_workers(count, 0);
    options.extra_arguments = {"--crash-building", "yes"};
    Farm farm(options);
    const JobResult result = farm.render(make_job(32, 32, 16), nullptr);
    EXPECT_EQ(result.report.exit_code, ExitCode::render_failed);
    EXPECT_THAT(result.report.failure,
                ::testing::MatchesRegex("building the scene ended the worker's process: process .* "
                                        "ended with signal 6 .ABRT.; that happened to 2 workers"));
  }
}

TEST(LocalWorkers, ThoseThatEndAtOnceFailTheJobInTime) {
  LocalWorkerOptions options = fake_workers(2, 0);
  options.extra_arguments = {"--fail", "yes"};
  Farm farm(options);
  const JobResult result = farm.render(make_job(32, 32, 16), nullptr);
  EXPECT_EQ(result.report.exit_code, ExitCode::render_failed);
  EXPECT_THAT(result.report.failure, ::testing::HasSubstr("exit code 9"));
  EXPECT_EQ(result.report.holes.size(), 4u);
}

TEST(LocalWorkers, ThoseThatEndedInVainAreStartedAgainLater) {
  const TemporaryFolder folder;
  const std::filesystem::path script = folder / "worker", broken = folder / "broken";
  std::ofstream(script) << "#!/bin/sh\nif [ -e " << broken.string() << " ]; then exit 3; fi\nexec "
                        << fake_worker() << " \"$@\"\n";
  std::ofstream(broken) << "yes";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  LocalWorkerOptions options = fake_workers(2, 0);
  options.program = script.string();
  Farm farm(options);
  const JobSpec job = make_job(64, 64, 16);
  for (int i = 0; i < 2; ++i) {
    const JobResult failed = farm.render(job, nullptr);
    EXPECT_EQ(failed.report.end, JobReport::End::failed);
    EXPECT_THAT(failed.report.failure, ::testing::HasSubstr("end as soon as they are started"));
  }
  std::filesystem::remove(broken);
  const JobResult done = farm.render(job, nullptr);
  EXPECT_EQ(done.film.pixels_sha256(), expected_sha256(job));
  farm.loop.shut_down("done");
}

TEST(LocalWorkers, AProgramThatIsNotThereIsAnError) {
  LocalWorkerOptions options = fake_workers(1, 0);
  options.program = "/nonexistent/worker";
  LocalWorkers workers(options);
  EXPECT_THROW(workers.start(), Error);
}

TEST(LocalWorkers, TooManyForTheLimitOfOpenFilesIsAnError) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const auto too_many = static_cast<int>(std::min<rlim_t>(before.rlim_max / 2, 1'000'000'000));
  EXPECT_THROW(LocalWorkers(fake_workers(too_many, 0)), Error);
  // Up to the hard limit it helps itself.
  rlimit low = before;
  low.rlim_cur = 64;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  const LocalWorkers some(fake_workers(64, 0));
  rlimit raised{};
  getrlimit(RLIMIT_NOFILE, &raised);
  EXPECT_GE(raised.rlim_cur, 128u);
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST(LocalWorkers, DieWithTheirParent) {
  // Who is killed cannot tidy up: its private folder goes into one of ours.
  const TemporaryFolder folder;
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t parent = fork();
  ASSERT_GE(parent, 0);
  if (parent == 0) {
    setenv("TMPDIR", folder.path().c_str(), 1);
    auto* workers = new LocalWorkers(fake_workers(2, 0));
    workers->start();
    const auto running = workers->processes();
    const auto size = static_cast<ssize_t>(running.size() * sizeof(pid_t));
    if (write(ends[1], running.data(), running.size() * sizeof(pid_t)) != size) _exit(1);
    pause();
    _exit(0);
  }
  pid_t processes[2] = {};
  const ssize_t got = read(ends[0], processes, sizeof processes);
  kill(parent, SIGKILL);
  EXPECT_EQ(got, static_cast<ssize_t>(sizeof processes));
  ASSERT_EQ(waitpid(parent, nullptr, 0), parent);
  for (const pid_t process : processes) {
    for (int i = 0; i < 500 && alive(process); ++i) std::this_thread::sleep_for(milliseconds(10));
    EXPECT_FALSE(alive(process));
  }
  // What it could not remove itself, the next one does, but not what is in use.
  const auto entries = [&folder] {
    const auto all = std::filesystem::directory_iterator(folder.path());
    return std::distance(begin(all), end(all));
  };
  EXPECT_EQ(entries(), 1);
  const char* before = std::getenv("TMPDIR");
  const std::string restored = before ? before : "";
  setenv("TMPDIR", folder.path().c_str(), 1);
  {
    const LocalWorkers one(fake_workers(0, 0));
    EXPECT_EQ(entries(), 1);
    const LocalWorkers two(fake_workers(0, 0));
    EXPECT_EQ(entries(), 2);
  }
  EXPECT_EQ(entries(), 0);
  before ? setenv("TMPDIR", restored.c_str(), 1) : unsetenv("TMPDIR");
}

}  // namespace
}  // namespace tessera::testing
