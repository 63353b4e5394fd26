#include "base/error.h"

#include <gtest/gtest.h>

#include <array>

namespace tessera {
namespace {

TEST(SourcePlace, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ((SourcePlace{"a.obj", 3, 7}).str(), "a.obj:3:7");
  EXPECT_EQ((SourcePlace{"a.obj", 3, 0}).str(), "a.obj:3");
  EXPECT_EQ((SourcePlace{"a.obj", 0, 7}).str(), "a.obj");
}

TEST(SceneError, ReadsPlaceFoundExpected) {
  const Error error = scene_error({"a.obj", 3, 7}, "found 'x'", "a number");
  EXPECT_STREQ(error.what(), "a.obj:3:7: found 'x'; expected a number");
  EXPECT_EQ(error.code(), ExitCode::bad_scene);
}

/// What a file holds may be in it: what() would end at a zero, and a terminal take commands from
/// it.
TEST(SceneError, HasNoControlCharacters) {
  const std::string found("a\0b\x1b[2J\nc", 9);
  EXPECT_STREQ(scene_error({"a\n.obj", 3, 7}, found, "\t").what(),
               "a\\n.obj:3:7: a\\x00b\\x1b[2J\\nc; expected \\t");
  for (const auto& make : {usage_error, render_error})
    EXPECT_STREQ(make(found).what(), "a\\x00b\\x1b[2J\nc") << "with the lines of whoever wrote it";
  EXPECT_STREQ(scene_error(found).what(), "a\\x00b\\x1b[2J\nc");
}

TEST(NearestName, FindsASlipOfThePenAndNothingFarther) {
  const std::array<std::string, 3> names{"whitted", "path", "normals"};
  EXPECT_EQ(nearest_name("whited", names), "whitted");
  EXPECT_EQ(nearest_name("PATH", names), "path");
  EXPECT_EQ(nearest_name("apth", names), "path");
  EXPECT_EQ(nearest_name("pthh", names), std::nullopt);
  EXPECT_EQ(nearest_name("octree", names), std::nullopt);
  EXPECT_EQ(suggestion("normal", names), "; did you mean 'normals'?");
}

TEST(NearestName, FindsWhatANameIsShortFor) {
  const std::array<std::string, 5> names{"owen-sobol", "blue-noise", "path", "forest", "id"};
  EXPECT_EQ(nearest_name("sobol", names), "owen-sobol");
  EXPECT_EQ(nearest_name("Owen", names), "owen-sobol");
  EXPECT_EQ(nearest_name("blue", names), "blue-noise");
  EXPECT_EQ(nearest_name("pathtracer", names), "path");
  EXPECT_EQ(nearest_name("frst", names), "forest");
  EXPECT_EQ(nearest_name("obol", names), std::nullopt) << "within a word";
  EXPECT_EQ(nearest_name("fst", names), std::nullopt) << "half of it";
  EXPECT_EQ(nearest_name("identity", names), std::nullopt) << "too short a name";
}

}  // namespace
}  // namespace tessera
