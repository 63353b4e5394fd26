// The timeline as Perfetto reads it.
#include "coordinator/web/chrome_trace.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tessera::testing {
namespace {

TEST(ChromeTrace, HasAProcessForEachWorkerAndRowsWithoutOverlap) {
  FrameTrace trace;
  trace.workers = {{7, "host:1 \"odd\""}, {9, "host:2"}};
  using Kind = FrameTrace::Kind;
  trace.spans = {{7, Kind::scene, 0, {}, 0, 0.5},
                 {7, Kind::tile, 0, {0, 0, 16, 16}, 0.5, 1.5},
                 {7, Kind::tile, 1, {16, 0, 32, 16}, 0.5, 2},
                 {9, Kind::wasted, 1, {16, 0, 32, 16}, 1, 2},
                 {7, Kind::tile, 2, {0, 16, 16, 32}, 1.5, 2.5}};
  trace.spans.push_back({9, Kind::lost, 7, {}, 2, 2.25});
  trace.left_out = 3;
  const auto json = nlohmann::json::parse(chrome_trace(trace, "job 1", {{"parse", -1, 0}}));
  EXPECT_EQ(json["otherData"]["spans_left_out"], 3);
  std::map<std::pair<int, int>, int64_t> until;
  std::map<int, std::string> processes;
  std::map<std::string, int> kinds;
  for (const auto& event : json["traceEvents"]) {
    if (event["ph"] == "M") {
      EXPECT_EQ(event["name"], "process_name");
      processes[event["pid"]] = event["args"]["name"];
      continue;
    }
    ASSERT_EQ(event["ph"], "X");
    ++kinds[event["cat"]];
    const auto row = std::pair<int, int>(event["pid"], event["tid"]);
    const int64_t begin = event["ts"], length = event["dur"];
    if (until.contains(row)) {
      EXPECT_GE(begin, until[row]) << event;
    }
    until[row] = begin + length;
    EXPECT_GE(length, 0);
  }
  EXPECT_EQ(processes.size(), 3u);
  EXPECT_EQ(processes[2], "host:1 \"odd\"");
  EXPECT_EQ(kinds, (std::map<std::string, int>{
                       {"phase", 1}, {"scene", 1}, {"tile", 3}, {"wasted", 1}, {"lost", 1}}));
  EXPECT_EQ(until.size(), 4u) << "ours, two rows of the first worker, one of the second";
  EXPECT_EQ((until[{2, 0}]), 3'500'000) << "microseconds, from the first phase on";
}

}  // namespace
}  // namespace tessera::testing
