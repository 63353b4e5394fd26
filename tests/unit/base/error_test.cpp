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

TEST(NearestName, FindsASlipOfThePenAndNothingFarther) {
  const std::array<std::string, 3> names{"whitted", "path", "normals"};
  EXPECT_EQ(nearest_name("whited", names), "whitted");
  EXPECT_EQ(nearest_name("PATH", names), "path");
  EXPECT_EQ(nearest_name("apth", names), "path");
  EXPECT_EQ(nearest_name("pthh", names), std::nullopt);
  EXPECT_EQ(nearest_name("octree", names), std::nullopt);
  EXPECT_EQ(suggestion("normal", names), "; did you mean 'normals'?");
}

}  // namespace
}  // namespace tessera
