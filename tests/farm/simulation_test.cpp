// Random schedules of trouble, each of which must end with the same picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "base/log.h"
#include "job/tile_grid.h"
#include "tests/farm/seeds.h"
#include "tests/farm/simulation.h"

namespace tessera::testing {
namespace {

constexpr uint64_t kSeeds = 12000;

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
  if (simulation.hasty_workers() > 0) return "a worker took its own absence for the coordinator's";
  return "";
}

class FarmSimulation : public ::testing::TestWithParam<uint64_t> {
 protected:
  void SetUp() override {
    spdlog::set_level(replayed_seed() ? spdlog::level::info : spdlog::level::off);
  }
};

TEST_P(FarmSimulation, EveryScheduleEndsWithTheSamePicture) {
  const std::vector<uint64_t> seeds = seeds_of(GetParam(), kSeeds);
  uint64_t retries = 0, duplicates = 0, speculative = 0, lost = 0;
  for (const uint64_t seed : seeds) {
    Simulation simulation(seed);
    simulation.trace = replayed_seed() != 0;
    const auto result = simulation.run();
    ASSERT_EQ(flaw(simulation, result), "")
        << "replay with TESSERA_SIM_SEED=" << seed << " farm_simulation_test";
    retries += result->report.retries;
    duplicates += result->report.duplicates;
    speculative += result->report.speculative;
    lost += result->report.workers_lost;
  }
  if (replayed_seed()) return;
  // The schedules must really have met with trouble.
  EXPECT_GT(retries, seeds.size() / 4);
  EXPECT_GT(duplicates, seeds.size() / 8);
  EXPECT_GT(speculative, seeds.size() / 8);
  EXPECT_GT(lost, seeds.size() / 4);
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

TEST_F(FarmMutation, AWorkerShortOfMemoryIsGivenFewerTilesAndIsNotBlamed) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const bool alone = seed % 4 == 0;
    Simulation simulation(seed, [alone](Faults& faults, CoordinatorOptions& options) {
      if (alone) options.verify = 0;
      if (alone) faults = Faults{};
      faults.one_starves = true;
      faults.one_alone = alone;
      faults.bad_scene = false;
    });
    const auto result = simulation.run();
    ASSERT_EQ(flaw(simulation, result), "") << "seed " << seed;
    if (!alone) continue;
    EXPECT_EQ(result->report.end, JobReport::End::done) << "seed " << seed;
    EXPECT_EQ(result->film.pixels_sha256(), expected_sha256(simulation.job())) << "seed " << seed;
  }
}

TEST_F(FarmMutation, AWorkerThatLiesIsCaught) {
  int caught = 0;
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    Simulation simulation(seed, [](Faults& faults, CoordinatorOptions& options) {
      options.verify = 0;
      faults.one_lies = true;
      faults.restarts = false;
      faults.bad_scene = false;
      faults.duplication = 0.3;
    });
    const auto result = simulation.run();
    ASSERT_TRUE(result);
    if (result->report.mismatches > 0) ++caught;
  }
  EXPECT_GT(caught, 40);
}

/// One worker of three lies in all its tiles; `share` of all tiles are verified.
std::function<void(Faults&, CoordinatorOptions&)> lying(double share, bool in_peace, uint64_t key) {
  return [=](Faults& faults, CoordinatorOptions& options) {
    if (in_peace) faults = Faults{};
    faults.one_lies = true;
    faults.restarts = faults.bad_scene = false;
    options.verify = share;
    options.verify_key = key;
  };
}

/// Tiles of the grid of `tile_size` whose pixels are wrong.
int wrong_tiles(const JobSpec& job, const Film& film) {
  int wrong = 0;
  for (const PixelRect& tile : cut_tiles(job.crop, job.tile_size)) {
    TileProgress progress;
    const auto right =
        FakeRenderer(job.frame.seed()).render({tile, 0, job.frame.samples_per_pixel()}, progress);
    const size_t width = static_cast<size_t>(tile.width()) * kFilmChannels;
    for (int y = tile.y0; y < tile.y1; ++y) {
      const size_t row = static_cast<size_t>(y - job.crop.y0) *
                             static_cast<size_t>(job.crop.width()) * kFilmChannels +
                         static_cast<size_t>(tile.x0 - job.crop.x0) * kFilmChannels;
      const auto there = film.values().subspan(row, width);
      const auto expected =
          std::span(right->values).subspan(width * static_cast<size_t>(y - tile.y0), width);
      if (std::ranges::equal(there, expected)) continue;
      ++wrong;
      break;
    }
  }
  return wrong;
}

TEST_F(FarmMutation, WhenAllIsVerifiedALiarChangesNoPicture) {
  int caught = 0, done = 0, unverified = 0;
  constexpr int kCount = 1500;
  for (uint64_t seed = 1; seed <= kCount; ++seed) {
    const bool in_peace = seed % 3 == 0;
    Simulation simulation(seed, lying(1, in_peace, seed));
    const auto result = simulation.run();
    ASSERT_TRUE(result) << "seed " << seed << " does not end";
    const JobReport& report = result->report;
    if (report.end == JobReport::End::done) {
      ++done;
      if (report.unverified == 0) {
        ASSERT_EQ(result->film.pixels_sha256(), expected_sha256(simulation.job())) << seed;
      }
      ASSERT_EQ(report.tiles_done, report.tiles_total);
    } else {
      // Those who could have decided were gone.
      ASSERT_FALSE(in_peace) << seed << ": " << report.failure;
      ASSERT_NE(report.failure.find("no third"), std::string::npos)
          << seed << ": " << report.failure;
    }
    if (report.liars > 0) ++caught;
    ASSERT_LE(report.liars, 1u) << seed;
    if (in_peace) {
      ASSERT_EQ(report.liars, report.mismatches > 0 ? 1u : 0u) << seed;
      // A worker may trace for longer than a lease what nobody wants of it any more.
      unverified += report.unverified > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(caught, kCount / 2);
  EXPECT_GT(done, kCount * 9 / 10);
  EXPECT_LT(unverified, kCount / 100);
}

TEST_F(FarmMutation, WhenAllIsVerifiedAKeyThatLiesByManyProcessesChangesNoPicture) {
  constexpr int kCount = 600;
  int caught = 0, done = 0;
  for (uint64_t seed = 1; seed <= kCount; ++seed) {
    const bool in_peace = seed % 2 == 0;
    Simulation simulation(seed, [&](Faults& faults, CoordinatorOptions& options) {
      if (in_peace) faults = Faults{};
      // A job of a client would be held until another worker comes.
      faults.by_client = false;
      faults.bad_scene = faults.restarts = faults.one_alone = false;
      faults.keys = 3;
      faults.key_lies = true;
      options.verify = 1;
      options.verify_key = seed;
    });
    const auto result = simulation.run();
    ASSERT_TRUE(result) << "seed " << seed << " does not end";
    const JobReport& report = result->report;
    caught += report.liars > 0;
    if (report.end != JobReport::End::done) {
      ASSERT_NE(report.failure.find("no third"), std::string::npos)
          << seed << ": " << report.failure;
      continue;
    }
    ++done;
    if (report.unverified > 0) continue;
    ASSERT_EQ(result->film.pixels_sha256(), expected_sha256(simulation.job())) << seed;
  }
  EXPECT_GT(caught, kCount / 3);
  EXPECT_GT(done, kCount / 2);
}

TEST_F(FarmMutation, ALiarEscapesNoMoreOftenThanThePromise) {
  constexpr double kShare = 0.2;
  constexpr int kCount = 600;
  double promised = 0;
  int escaped = 0, lied = 0;
  for (uint64_t seed = 1; seed <= kCount; ++seed) {
    Simulation without(seed, lying(0, true, 0));
    const auto unseen = without.run();
    ASSERT_TRUE(unseen);
    const int wrong = wrong_tiles(without.job(), unseen->film);
    if (wrong == 0 || unseen->report.mismatches > 0) continue;
    ++lied;
    promised += std::pow(1 - kShare, wrong);
    Simulation with(seed, lying(kShare, true, seed));
    const auto result = with.run();
    ASSERT_TRUE(result);
    escaped += wrong_tiles(with.job(), result->film) > 0 ? 1 : 0;
  }
  ASSERT_GT(lied, kCount / 3);
  EXPECT_LE(escaped, promised + 4 * std::sqrt(promised));
  EXPECT_GT(escaped, 0) << "a share of tiles is not all of them";
}

TEST_F(FarmMutation, OneWorkerAloneIsNotVerifiedAndSaysSo) {
  Simulation simulation(5, [](Faults& faults, CoordinatorOptions& options) {
    faults = Faults{};
    faults.one_alone = true;
    options.verify = 1;
  });
  const auto result = simulation.run();
  ASSERT_TRUE(result);
  EXPECT_EQ(flaw(simulation, result), "");
  EXPECT_EQ(result->report.unverified, result->report.tiles_total);
  EXPECT_EQ(result->report.verified, 0u);
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
