#include "bench/skip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {

void PrintTo(const UnneededKind& kind, std::ostream* out) { *out << kind.name; }

namespace {

class Unneeded : public testing::TestWithParam<UnneededKind> {};

TEST_P(Unneeded, ChangesNoBitAndIsLeftOut) {
  const SkipRow row = bench_skip(GetParam(), {.repeats = 1, .quick = true});
  EXPECT_TRUE(row.same_bits);
  if (GetParam().counters.empty()) return;
  // Attributes are counted by the array.
  EXPECT_GE(row.left_out, GetParam().name == "attributes" ? 2 : 1000);
}

INSTANTIATE_TEST_SUITE_P(Every, Unneeded, testing::ValuesIn(unneeded_kinds()),
                         [](const testing::TestParamInfo<UnneededKind>& tested) {
                           std::string name = tested.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(SkipBench, SeesWhatChangesThePicture) {
  const UnneededKind needed{"needed", "a ball before the camera", [](LoadedScene& scene) {
                              v1::Sphere& ball =
                                  *scene.scene.add_nodes()->mutable_shape()->mutable_sphere();
                              ball.mutable_center()->set_y(1);
                              ball.set_radius(1);
                            }};
  EXPECT_FALSE(bench_skip(needed, {.repeats = 1, .quick = true}).same_bits);
}

TEST(SkipBench, IsToldInTableAndJson) {
  const SkipRow row{.name = "something", .description = "of a kind", .left_out = 7, .ratio = 1.5};
  EXPECT_NE(skip_table({row}).find("BEYOND"), std::string::npos);
  const auto found = nlohmann::json::parse(skip_json({row}));
  EXPECT_EQ(found["rows"][0]["unneeded"], "something");
  EXPECT_EQ(found["rows"][0]["left_out"], 7);
  EXPECT_EQ(found["rows"][0]["same_bits"], false);
}

}  // namespace
}  // namespace tessera
