// Random schedules of trouble, each of which must end with the same picture.
// TESSERA_SIM_SEED=N replays one seed and tells what happens; TESSERA_SIM_SEEDS=N sets how many
// there are in all.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "base/log.h"
#include "tests/farm/simulation.h"

namespace tessera::testing {
namespace {

constexpr uint64_t kShards = 8;
constexpr uint64_t kSeeds = 12000;

uint64_t from_environment(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

/// What is wrong with a run; empty: nothing.
std::string flaw(const Simulation& simulation, const std::optional<JobResult>& result) {
  if (!result) return "it does not end";
  const JobReport& report = result->report;
  if (simulation.faults().bad_scene) {
    return report.exit_code == ExitCode::bad_scene ? "" : "a bad scene is not reported";
  }
  if (report.end != JobReport::End::done) return "it fails: " + report.failure;
  if (result->film.pixels_sha256() != expected_sha256(simulation.job())) return "another picture";
  if (report.tiles_done != report.tiles_total) return "tiles are missing";
  const auto rays = static_cast<uint64_t>(simulation.job().crop.area()) * 4;
  if (report.counters.at("rays_primary") != rays)
    return "a tile was counted more or less than once";
  if (report.mismatches != 0) return "pixels differ";
  return "";
}

class FarmSimulation : public ::testing::TestWithParam<uint64_t> {
 protected:
  void SetUp() override { spdlog::set_level(spdlog::level::off); }
};

TEST_P(FarmSimulation, EveryScheduleEndsWithTheSamePicture) {
  if (const uint64_t seed = from_environment("TESSERA_SIM_SEED", 0)) {
    if (GetParam() != 0) GTEST_SKIP() << "a replay of one seed runs in the first shard alone";
    spdlog::set_level(spdlog::level::info);
    Simulation simulation(seed);
    simulation.trace = true;
    ASSERT_EQ(flaw(simulation, simulation.run()), "");
    return;
  }
  const uint64_t count = from_environment("TESSERA_SIM_SEEDS", kSeeds) / kShards;
  uint64_t retries = 0, duplicates = 0, speculative = 0, lost = 0;
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t seed = 1 + GetParam() * count + i;
    Simulation simulation(seed);
    const auto result = simulation.run();
    ASSERT_EQ(flaw(simulation, result), "")
        << "replay with TESSERA_SIM_SEED=" << seed << " farm_simulation_test";
    retries += result->report.retries;
    duplicates += result->report.duplicates;
    speculative += result->report.speculative;
    lost += result->report.workers_lost;
  }
  // The schedules must really have met with trouble.
  EXPECT_GT(retries, count / 4);
  EXPECT_GT(duplicates, count / 8);
  EXPECT_GT(speculative, count / 8);
  EXPECT_GT(lost, count / 4);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FarmSimulation, ::testing::Range<uint64_t>(0, kShards));

class FarmMutation : public FarmSimulation {};

/// How many of the first `count` seeds are flawed under a planted defect.
template <typename Adjust>
int flawed(int count, const Adjust& adjust) {
  int result = 0;
  for (int seed = 1; seed <= count; ++seed) {
    Simulation simulation(static_cast<uint64_t>(seed), adjust);
    if (!flaw(simulation, simulation.run()).empty()) ++result;
  }
  return result;
}

TEST_F(FarmMutation, AWorkerThatLiesIsCaught) {
  int caught = 0;
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    Simulation simulation(seed, [](Faults& faults, CoordinatorOptions&) {
      faults.one_lies = true;
      faults.restarts = false;
      faults.bad_scene = false;
      faults.duplication = 0.3;
    });
    const auto result = simulation.run();
    ASSERT_TRUE(result);
    if (result->report.mismatches > 0) ++caught;
  }
  EXPECT_GT(caught, 60);
}

TEST_F(FarmMutation, WithoutReissueJobsDoNotEnd) {
  const auto never = [](Faults&, CoordinatorOptions& options) {
    options.lost_after = options.suspect_after = options.lease = options.settle =
        std::chrono::hours(10);
    options.speculate_after = std::chrono::hours(10);
  };
  EXPECT_GT(flawed(100, never), 30);
}

TEST_F(FarmMutation, ARestartAndABadSceneAreSurvivedAlone) {
  const auto restart = [](Faults& faults, CoordinatorOptions&) {
    faults.bad_scene = false;
    faults.restarts = true;
  };
  EXPECT_EQ(flawed(100, restart), 0);
  const auto bad = [](Faults& faults, CoordinatorOptions&) {
    faults.bad_scene = true;
    faults.loss = 0.3;
  };
  EXPECT_EQ(flawed(100, bad), 0);
}

TEST_F(FarmMutation, AHangThatNoLeaseEndsIsNoticed) {
  const auto hang = [](Faults& faults, CoordinatorOptions& options) {
    faults = Faults{};
    faults.one_hangs = true;
    options.speculate_after = std::chrono::hours(10);
    options.lease = std::chrono::hours(10);
  };
  EXPECT_GT(flawed(50, hang), 25);
  const auto sound = [](Faults& faults, CoordinatorOptions& options) {
    faults = Faults{};
    faults.one_hangs = true;
    options.speculate_after = std::chrono::hours(10);
  };
  EXPECT_EQ(flawed(50, sound), 0);
}

}  // namespace
}  // namespace tessera::testing
