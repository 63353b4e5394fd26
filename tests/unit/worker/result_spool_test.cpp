#include "worker/result_spool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>

#include "tests/file_size_limit.h"
#include "tests/temporary_folder.h"
#include "worker/blob_cache.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kBudget = 1 << 20;

/// What is logged while it lives.
class Log {
 public:
  Log() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(lines_)));
  }
  ~Log() { spdlog::set_default_logger(before_); }
  std::string text() const { return lines_.str(); }

 private:
  std::shared_ptr<spdlog::logger> before_;
  std::ostringstream lines_;
};

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

TEST_F(ResultSpoolTest, EachWhoTakesItOverHasSessionsOfItsOwn) {
  leave_two();
  const uint64_t second = open().origin().value().session;
  const uint64_t third = open().origin().value().session;
  EXPECT_GT(third, second + 1000);
  // What the third one leaves in a file of its own is behind its sessions too.
  {
    ResultSpool spool = open();
    hello_.set_session(spool.origin()->session + 7);
    leases(spool);
    spool.keep(hello_, 9, band(1));
  }
  EXPECT_GT(open().origin().value().session, hello_.session());
}

TEST_F(ResultSpoolTest, OfSeveralFilesOneIsTakenOverAndThoseOfNoUseAreRemoved) {
  leave_two();
  fs::last_write_time(file(), fs::file_time_type::clock::now() - std::chrono::hours(25));
  const fs::path old = file();
  { ResultSpool first(folder_.path(), kBudget, "n2"), other(folder_.path(), kBudget, "n2"); }
  EXPECT_FALSE(fs::exists(old));
  hello_.set_worker_id(6);
  auto one = std::make_unique<ResultSpool>(folder_.path(), kBudget, "n");
  one->keep(hello_, 9, band(1));
  leave_two();  // of worker 5, since that of 6 lives
  hello_.set_worker_id(5);
  leave_two();
  one.reset();
  EXPECT_EQ(files(), 2u);
  ResultSpool spool = open();
  EXPECT_EQ(spool.origin().value().worker_id, 5u);
  EXPECT_EQ(open().origin().value().worker_id, 6u);
  EXPECT_EQ(files(), 2u);
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
    const Log log;
    ResultSpool spool = open();
    EXPECT_LE(leases(spool).size(), 1u) << at;
    EXPECT_THAT(log.text(), ::testing::ContainsRegex("is removed|are damaged")) << at;
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

TEST_F(ResultSpoolTest, AllWorkersOfAFolderHaveOneBudget) {
  ResultSpool first = open(3000), second = open(3000);
  EXPECT_TRUE(first.keep(hello_, 9, band(1)));
  hello_.set_worker_id(6);
  EXPECT_TRUE(second.keep(hello_, 9, band(2)));
  EXPECT_FALSE(second.keep(hello_, 9, band(3)));
  EXPECT_EQ(leases(first), std::vector<uint64_t>{1});
  EXPECT_FALSE(second.keep(hello_, 9, band(4))) << "it looks again once it is empty";
  EXPECT_EQ(leases(second), std::vector<uint64_t>{2});
  EXPECT_TRUE(second.keep(hello_, 9, band(5)));
}

TEST_F(ResultSpoolTest, WhoFoundNoRoomForAFileLooksAgain) {
  auto other = std::make_unique<ResultSpool>(folder_.path(), 3000, "n");
  while (other->keep(hello_, 9, band(1))) {
  }
  ResultSpool spool = open(3000);
  v1::Hello hello = hello_;
  hello.set_worker_id(hello.worker_id() + 1);
  EXPECT_FALSE(spool.keep(hello, 9, band(1)));
  leases(*other);
  leases(spool);
  EXPECT_TRUE(spool.keep(hello, 9, band(1)));
}

TEST_F(ResultSpoolTest, BlobsMakeRoomForResults) {
  BlobCache cache(folder_.path(), 3000);
  const Blob blob(std::vector<std::byte>(2500));
  cache.keep(Digest::of(blob), blob);
  EXPECT_EQ(files(), 1u);
  ResultSpool spool = open(3000);
  EXPECT_TRUE(spool.keep(hello_, 9, band(1)));
  EXPECT_EQ(files(), 1u);
  cache.keep(Digest::of(blob), blob);
  EXPECT_EQ(files(), 1u) << "and do not make results go";
  leases(spool);
  cache.keep(Digest::of(blob), blob);
  EXPECT_EQ(files(), 1u);
}

TEST_F(ResultSpoolTest, WhereNothingCanBeWrittenNothingIsLeft) {
  ResultSpool spool = open();
  const auto descriptors = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), {});
  };
  const auto open_before = descriptors();
  {
    const FileSizeLimit none(10);
    EXPECT_FALSE(spool.keep(hello_, 9, band(1)));
  }
  EXPECT_TRUE(spool.empty());
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(descriptors(), open_before);
}

TEST_F(ResultSpoolTest, AFullDiskTakesNothingThatWasKeptBefore) {
  ResultSpool spool = open();
  {
    const FileSizeLimit small(1500);
    for (const uint64_t lease : {1u, 2u}) spool.keep(hello_, 9, band(lease));
  }
  spool.keep(hello_, 9, band(3));
  EXPECT_EQ(leases(spool), (std::vector<uint64_t>{1, 3}));
}

}  // namespace
}  // namespace tessera
