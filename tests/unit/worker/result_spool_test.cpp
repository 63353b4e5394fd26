#include "worker/result_spool.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kBudget = 1 << 20;

class ResultSpoolTest : public ::testing::Test {
 protected:
  ResultSpoolTest() {
    hello_.set_worker_id(5);
    hello_.set_session(3);
    hello_.set_numerics_id("n");
  }
  void SetUp() override { spdlog::set_level(spdlog::level::off); }
  void TearDown() override { spdlog::set_level(spdlog::level::info); }

  static v1::Envelope band(uint64_t lease) {
    v1::Envelope result;
    result.mutable_tile_band()->set_lease(lease);
    result.mutable_tile_band()->set_pixels(std::string(1000, 'x'));
    return result;
  }
  ResultSpool open(uint64_t budget = kBudget) { return {folder_.path(), budget, "n"}; }
  static std::vector<uint64_t> leases(ResultSpool& spool, uint64_t farm = 9) {
    std::vector<uint64_t> found;
    spool.hand_in(farm, [&](const v1::Envelope& r) { found.push_back(r.tile_band().lease()); });
    return found;
  }
  size_t files() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_.path()), {}));
  }
  /// Leaves two results of farm 9.
  void leave_two() {
    ResultSpool spool = open();
    for (const uint64_t lease : {1u, 2u}) spool.keep(hello_, 9, band(lease));
  }
  fs::path file() const { return fs::directory_iterator(folder_.path())->path(); }

  const TemporaryFolder folder_;
  v1::Hello hello_;
};

TEST_F(ResultSpoolTest, HandsInWhatAnEndedWorkerLeftUnderItsId) {
  EXPECT_FALSE(open().origin());
  leave_two();
  ResultSpool spool = open();
  ASSERT_TRUE(spool.origin());
  EXPECT_EQ(spool.origin()->worker_id, 5u);
  EXPECT_GT(spool.origin()->session, 3u);
  EXPECT_EQ(spool.origin()->farm, 9u);
  EXPECT_FALSE(open().origin()) << "one takes it over, not two";
  EXPECT_EQ(leases(spool), (std::vector<uint64_t>{1, 2}));
  EXPECT_TRUE(spool.empty());
  EXPECT_EQ(files(), 0u);
}

TEST_F(ResultSpoolTest, ItIsForThisUserAlone) {
  leave_two();
  EXPECT_EQ(fs::status(file()).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(ResultSpoolTest, ResultsOfAnotherFarmOrNumericsAreDropped) {
  leave_two();
  {
    ResultSpool spool = open();
    EXPECT_EQ(leases(spool, 10), std::vector<uint64_t>());
  }
  EXPECT_EQ(files(), 0u);
  leave_two();
  EXPECT_FALSE(ResultSpool(folder_.path(), kBudget, "other").origin());
  EXPECT_EQ(files(), 0u);
}

TEST_F(ResultSpoolTest, WhatIsTooOldIsDropped) {
  leave_two();
  fs::last_write_time(file(), fs::file_time_type::clock::now() - std::chrono::hours(25));
  EXPECT_FALSE(open().origin());
  EXPECT_EQ(files(), 0u);
}

TEST_F(ResultSpoolTest, WhatIsDamagedOrTornIsLeftOut) {
  leave_two();
  const fs::path path = file();
  std::ifstream in(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  for (size_t cut = 0; cut < whole.size(); cut += 7) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, cut);
    ResultSpool spool = open();
    EXPECT_LE(leases(spool).size(), 1u) << cut;
  }
  for (size_t at = 0; at < whole.size(); at += 7) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    std::ofstream(path, std::ios::binary) << damaged;
    ResultSpool spool = open();
    EXPECT_LE(leases(spool).size(), 1u) << at;
  }
}

TEST_F(ResultSpoolTest, NothingButResultsIsHandedIn) {
  v1::Envelope bye;
  bye.mutable_bye();
  ResultSpool spool = open();
  spool.keep(hello_, 9, bye);
  EXPECT_TRUE(spool.empty());
}

TEST_F(ResultSpoolTest, WhatGoesBeyondTheBudgetIsDropped) {
  ResultSpool spool = open(3000);
  for (const uint64_t lease : {1u, 2u, 3u, 4u}) spool.keep(hello_, 9, band(lease));
  EXPECT_LE(fs::file_size(file()), 3000u);
  EXPECT_EQ(leases(spool), (std::vector<uint64_t>{1, 2}));
}

TEST_F(ResultSpoolTest, AFullDiskTakesNothingThatWasKeptBefore) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 1500;
  ResultSpool spool = open();
  setrlimit(RLIMIT_FSIZE, &small);
  for (const uint64_t lease : {1u, 2u}) spool.keep(hello_, 9, band(lease));
  setrlimit(RLIMIT_FSIZE, &before);
  spool.keep(hello_, 9, band(3));
  EXPECT_EQ(leases(spool), (std::vector<uint64_t>{1, 3}));
}

}  // namespace
}  // namespace tessera
