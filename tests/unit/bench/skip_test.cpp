#include "bench/skip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {

void PrintTo(const SkipCase& skip, std::ostream* out) { *out << skip.name; }

namespace {

class Skip : public testing::TestWithParam<SkipCase> {};

TEST_P(Skip, is_counted_and_keeps_the_picture) {
  const SkipRow row = bench_skip(GetParam(), {.repeats = 1, .quick = true});
  EXPECT_TRUE(row.within) << row.difference << " of " << row.limit;
  EXPECT_TRUE(row.same_bits || GetParam().bound != SkipBound::bits);
  EXPECT_GT(row.skipped, 0u);
  EXPECT_GE(row.of, row.skipped);
}

INSTANTIATE_TEST_SUITE_P(Every, Skip, testing::ValuesIn(skip_cases()),
                         [](const testing::TestParamInfo<SkipCase>& tested) {
                           std::string name = tested.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(Skips, have_a_case_each) { EXPECT_EQ(skip_cases().size(), sizeof(Skips) / sizeof(bool)); }

TEST(Skips, are_told_in_table_and_json) {
  SkipRow row{.name = "something", .scene = "a scene", .bound = SkipBound::rms, .limit = .25};
  row.difference = .5;
  EXPECT_NE(skip_table({row}).find("BEYOND"), std::string::npos);
  const auto found = nlohmann::json::parse(skip_json({row}));
  EXPECT_EQ(found["rows"][0]["skip"], "something");
  EXPECT_EQ(found["rows"][0]["bound"], "rms");
  EXPECT_EQ(found["rows"][0]["within"], false);
}

}  // namespace
}  // namespace tessera
