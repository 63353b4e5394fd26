// The log as lines of JSON, whatever is said.
#include "base/json_log.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "base/log.h"

namespace tessera {
namespace {

TEST(JsonLog, IsAnObjectALine) {
  const auto before = spdlog::default_logger();
  std::ostringstream lines;
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "serve", std::make_shared<spdlog::sinks::ostream_sink_mt>(lines)));
  log_as_json();
  spdlog::info("job {} has come", 7);
  spdlog::warn("\"quoted\"\nand\tno UTF-8: \xff");
  spdlog::set_default_logger(before);
  std::istringstream read(lines.str());
  std::string first, second, third;
  ASSERT_TRUE(std::getline(read, first) && std::getline(read, second));
  EXPECT_FALSE(std::getline(read, third));
  const auto json = nlohmann::json::parse(first);
  EXPECT_EQ(json["level"], "info");
  EXPECT_EQ(json["process"], "serve");
  EXPECT_EQ(json["text"], "job 7 has come");
  const std::string time = json["time"];
  EXPECT_EQ(time.size(), std::string("2026-03-01T12:00:00.123Z").size()) << time;
  EXPECT_EQ(nlohmann::json::parse(second)["text"], "\"quoted\"\nand\tno UTF-8: \xef\xbf\xbd");
}

TEST(TextLog, HasDateAndZone) {
  const auto before = spdlog::default_logger();
  testing::internal::CaptureStderr();
  configure_logging("info", "serve");
  spdlog::info("job 7 has come");
  spdlog::default_logger()->flush();
  const std::string line = testing::internal::GetCapturedStderr();
  spdlog::set_default_logger(before);
  EXPECT_TRUE(std::regex_match(
      line,
      std::regex(
          R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d serve info job 7 has come\n)")))
      << line;
}

}  // namespace
}  // namespace tessera
