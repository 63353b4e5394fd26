// Many jobs, orders about them, and a coordinator that is killed at writes of its store.
// TESSERA_SIM_SEED=N replays one seed and tells what happens; TESSERA_SIM_SEEDS=N sets how many
// there are in all.
#include "tests/farm/service_simulation.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "base/log.h"

namespace tessera::testing {
namespace {

constexpr uint64_t kShards = 8;
constexpr uint64_t kSeeds = 1600;

uint64_t from_environment(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

class FarmService : public ::testing::TestWithParam<uint64_t> {
 protected:
  void SetUp() override { spdlog::set_level(spdlog::level::off); }
};

TEST_P(FarmService, EveryScheduleEndsWithTheSamePictures) {
  if (const uint64_t seed = from_environment("TESSERA_SIM_SEED", 0)) {
    if (GetParam() != 0) GTEST_SKIP() << "a replay of one seed runs in the first shard alone";
    spdlog::set_level(spdlog::level::info);
    ServiceSimulation simulation(seed);
    simulation.trace = true;
    ASSERT_EQ(simulation.run_service(), "");
    return;
  }
  const uint64_t count = from_environment("TESSERA_SIM_SEEDS", kSeeds) / kShards;
  uint64_t restarts = 0, restored = 0, cancelled = 0;
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t seed = 1 + GetParam() * count + i;
    ServiceSimulation simulation(seed);
    ASSERT_EQ(simulation.run_service(), "")
        << "replay with TESSERA_SIM_SEED=" << seed << " farm_service_simulation_test";
    restarts += static_cast<uint64_t>(simulation.restarts());
    restored += simulation.restored();
    cancelled += static_cast<uint64_t>(simulation.cancelled());
  }
  // The schedules must really have met with trouble.
  EXPECT_GT(restarts, count / 4);
  EXPECT_GT(restored, count / 2);
  EXPECT_GT(cancelled, count / 64);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FarmService, ::testing::Range<uint64_t>(0, kShards));

}  // namespace
}  // namespace tessera::testing
