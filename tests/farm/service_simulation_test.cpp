// Many jobs, orders about them, and a coordinator that is killed at writes of its store.
#include "tests/farm/service_simulation.h"

#include <gtest/gtest.h>

#include "base/log.h"
#include "tests/farm/seeds.h"

namespace tessera::testing {
namespace {

constexpr uint64_t kSeeds = 1600;

class FarmService : public ::testing::TestWithParam<uint64_t> {
 protected:
  void SetUp() override {
    spdlog::set_level(replayed_seed() ? spdlog::level::info : spdlog::level::off);
  }
};

TEST_P(FarmService, EveryScheduleEndsWithTheSamePictures) {
  const std::vector<uint64_t> seeds = seeds_of(GetParam(), kSeeds);
  uint64_t restarts = 0, restored = 0, cancelled = 0, handed_in = 0;
  for (const uint64_t seed : seeds) {
    ServiceSimulation simulation(seed);
    simulation.trace = replayed_seed() != 0;
    ASSERT_EQ(simulation.run_service(), "")
        << "replay with TESSERA_SIM_SEED=" << seed << " farm_service_simulation_test";
    restarts += static_cast<uint64_t>(simulation.restarts());
    restored += simulation.restored();
    handed_in += simulation.handed_in() > 0;
    cancelled += static_cast<uint64_t>(simulation.cancelled());
  }
  if (replayed_seed()) return;
  // The schedules must really have met with trouble.
  EXPECT_GT(restarts, seeds.size() / 4);
  EXPECT_GT(restored, seeds.size() / 2);
  EXPECT_GT(cancelled, seeds.size() / 64);
  EXPECT_GT(handed_in, seeds.size() / 32);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FarmService, ::testing::Range<uint64_t>(0, kShards));

}  // namespace
}  // namespace tessera::testing
