// /metrics, read by the rules of Prometheus' text format 0.0.4.
#include "coordinator/web/metrics_text.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace tessera::testing {
namespace {

/// Samples by name and labels. Adds a failure for each line that breaks a rule.
class StrictReader {
 public:
  explicit StrictReader(const std::string& text) {
    EXPECT_TRUE(text.ends_with('\n'));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) read(line);
    end_family();
    for (const auto& [name, type] : types_) {
      if (type != "histogram") continue;
      EXPECT_EQ(samples_.at(name + "_bucket{le=\"+Inf\"}"), samples_.at(name + "_count"));
      EXPECT_TRUE(samples_.contains(name + "_sum"));
    }
  }
  double value(const std::string& name) const { return samples_.at(name); }
  bool has(const std::string& name) const { return samples_.contains(name); }

 private:
  void read(const std::string& line) {
    static const std::regex help("# HELP ([a-zA-Z_:][a-zA-Z0-9_:]*) (.+)");
    static const std::regex type("# TYPE ([a-zA-Z_:][a-zA-Z0-9_:]*) (counter|gauge|histogram)");
    static const std::regex sample(
        R"(([a-zA-Z_:][a-zA-Z0-9_:]*)(\{([a-z_]+="[^"\\\n]*")(,[a-z_]+="[^"\\\n]*")*\})? (\S+))");
    std::smatch match;
    if (std::regex_match(line, match, help)) {
      end_family();
      family_ = match[1];
      EXPECT_TRUE(families_.insert(family_).second) << "twice: " << line;
    } else if (std::regex_match(line, match, type)) {
      EXPECT_EQ(match[1], family_) << line;
      types_[family_] = match[2];
      if (match[2] == "counter") {
        EXPECT_TRUE(family_.ends_with("_total")) << line;
      }
      if (match[2] == "gauge") {
        EXPECT_FALSE(family_.ends_with("_total")) << line;
      }
    } else if (std::regex_match(line, match, sample)) {
      read_sample(match[1], match[2], match[5], line);
    } else {
      ADD_FAILURE() << "no line of the format: " << line;
    }
  }
  void read_sample(const std::string& name, const std::string& labels, const std::string& number,
                   const std::string& line) {
    ASSERT_TRUE(types_.contains(family_)) << line;
    std::string base = name;
    if (types_[family_] == "histogram") {
      base = name.substr(0, name.rfind('_'));
      const std::string part = name.substr(base.size());
      EXPECT_TRUE(part == "_bucket" || part == "_sum" || part == "_count") << line;
      if (part == "_bucket") {
        EXPECT_GE(std::stod(number), last_bucket_) << line;
        last_bucket_ = std::stod(number);
      }
    }
    EXPECT_EQ(base, family_) << line;
    size_t used = 0;
    const double value = std::stod(number, &used);
    EXPECT_EQ(used, number.size()) << line;
    EXPECT_TRUE(samples_.emplace(name + labels, value).second) << "twice: " << line;
    ++in_family_;
  }
  void end_family() {
    if (!family_.empty()) {
      EXPECT_GT(in_family_, 0) << family_;
    }
    in_family_ = 0;
    last_bucket_ = 0;
  }

  std::string family_;
  int in_family_ = 0;
  double last_bucket_ = 0;
  std::set<std::string> families_;
  std::map<std::string, std::string> types_;
  std::map<std::string, double> samples_;
};

TEST(MetricsText, KeepsTheFormat) {
  FarmSnapshot snapshot;
  const StrictReader empty(metrics_text(snapshot, {}, {}, {}));
  EXPECT_EQ(empty.value("tessera_queue_tiles"), 0);
  EXPECT_EQ(empty.value("tessera_tile_seconds_count"), 0);
  EXPECT_EQ(empty.value("tessera_store_trouble"), 0);
}

TEST(MetricsText, TellsTheFarm) {
  FarmSnapshot snapshot;
  snapshot.store_trouble = "full \"disk\"\n";
  for (const auto state : {FarmSnapshot::JobState::running, FarmSnapshot::JobState::queued,
                           FarmSnapshot::JobState::paused, FarmSnapshot::JobState::done}) {
    FarmSnapshot::Job job;
    job.name = "hostile\"} 1\n";
    job.state = state;
    job.tiles_total = 10;
    job.tiles_done = 4;
    snapshot.jobs.push_back(job);
  }
  FarmSnapshot::Worker worker;
  worker.threads = 4;
  worker.credit = 6;
  worker.tiles_held = 5;
  worker.resident_bytes = 1000;
  snapshot.workers = {worker, worker};
  worker.state = FarmSnapshot::WorkerState::lost;
  worker.tiles_held = 0;
  snapshot.workers.push_back(worker);
  snapshot.counters.note_tile(0.001);
  snapshot.counters.note_tile(0.02);
  snapshot.counters.note_tile(1e6);
  snapshot.counters.commit_seconds.note(0.0002);
  snapshot.counters.commit_seconds.note(2);
  snapshot.counters.retries = 3;
  snapshot.counters.bytes_scene = 123'456'789'012;
  FarmMonitor::Work work;
  work.previews = 7;
  const StrictReader read(metrics_text(snapshot, work, {11, 5}, {2048, 1.5, 9}));
  EXPECT_EQ(read.value("tessera_jobs{state=\"running\"}"), 1);
  EXPECT_EQ(read.value("tessera_jobs{state=\"failed\"}"), 0);
  EXPECT_EQ(read.value("tessera_queue_tiles"), 12) << "of what is paused, none";
  EXPECT_EQ(read.value("tessera_workers{state=\"active\"}"), 2);
  EXPECT_EQ(read.value("tessera_workers{state=\"lost\"}"), 1);
  EXPECT_EQ(read.value("tessera_worker_threads"), 8);
  EXPECT_EQ(read.value("tessera_worker_credit_tiles"), 12);
  EXPECT_EQ(read.value("tessera_tiles_in_flight"), 10);
  EXPECT_EQ(read.value("tessera_worker_resident_bytes"), 2000);
  EXPECT_EQ(read.value("tessera_tiles_total{state=\"done\"}"), 3);
  EXPECT_EQ(read.value("tessera_tile_seconds_bucket{le=\"0.001\"}"), 1) << "the bound is in it";
  EXPECT_EQ(read.value("tessera_tile_seconds_bucket{le=\"0.01\"}"), 1);
  EXPECT_EQ(read.value("tessera_tile_seconds_bucket{le=\"100\"}"), 2);
  EXPECT_EQ(read.value("tessera_tile_seconds_bucket{le=\"+Inf\"}"), 3);
  EXPECT_DOUBLE_EQ(read.value("tessera_tile_seconds_sum"), 1e6 + 0.021);
  EXPECT_EQ(read.value("tessera_store_commit_seconds_bucket{le=\"0.0003\"}"), 1);
  EXPECT_EQ(read.value("tessera_store_commit_seconds_count"), 2);
  EXPECT_EQ(read.value("tessera_store_commit_seconds_sum"), 2.0002);
  EXPECT_EQ(read.value("tessera_tile_retries_total"), 3);
  EXPECT_EQ(read.value("tessera_wire_bytes_total{kind=\"scene\"}"), 123'456'789'012);
  EXPECT_EQ(read.value("tessera_store_trouble"), 1);
  EXPECT_EQ(read.value("tessera_coordinator_open_files"), 9);
  EXPECT_EQ(read.value("tessera_coordinator_cpu_seconds_total"), 1.5);
  EXPECT_EQ(read.value("tessera_web_previews_total"), 7);
  EXPECT_EQ(read.value("tessera_web_previews_encoded_total"), 5);
}

}  // namespace
}  // namespace tessera::testing
