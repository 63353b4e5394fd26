#include "front/placement.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/error_of.h"

namespace tessera {
namespace {

std::string error(std::string_view text) {
  return usage_error_of([text] { parse_placement(text); });
}

TEST(Placement, ReadsEveryPart) {
  const v1::Include placed =
      parse_placement("a/b:c.obj:at=1,-2,.5:rotate=0,90,10:scale=2,3,4:mirror=xz");
  EXPECT_EQ(placed.file(), "a/b:c.obj");
  ASSERT_EQ(placed.transform().steps_size(), 4) << "no turn about x";
  EXPECT_EQ(placed.transform().steps(0).translate().y(), -2);
  EXPECT_EQ(placed.transform().steps(1).rotate().angle(), 90);
  EXPECT_EQ(placed.transform().steps(1).rotate().axis().y(), 1);
  EXPECT_EQ(placed.transform().steps(2).rotate().axis().z(), 1);
  const v1::Vec3& scale = placed.transform().steps(3).scale();
  EXPECT_EQ(scale.x(), -2);
  EXPECT_EQ(scale.y(), 3);
  EXPECT_EQ(scale.z(), -4);
}

TEST(Placement, NeedsNoPart) {
  EXPECT_EQ(parse_placement("a.obj").file(), "a.obj");
  EXPECT_EQ(parse_placement("a.obj").transform().steps_size(), 0);
  EXPECT_EQ(parse_placement(":mirror=y").file(), "");
  EXPECT_EQ(parse_placement(":mirror=y").transform().steps(0).scale().y(), -1);
  EXPECT_EQ(parse_placement("a.obj:scale=.5").transform().steps(0).scale().z(), .5);
}

TEST(Placement, SaysWhatIsWrong) {
  EXPECT_EQ(error("a.obj:rotat=1,2,3"),
            "--place: 'rotat'; expected at, rotate, scale or mirror; did you mean 'rotate'?");
  EXPECT_EQ(error("a.obj:at=1,2"),
            "--place: 'at=1,2'; expected three numbers, such as at=1,0,-2.5");
  EXPECT_EQ(error("a.obj:at=1,2,x"), "--place at: 'x'; expected a finite number");
  EXPECT_EQ(error("a.obj:scale=x"), "--place scale: 'x'; expected a finite number");
  EXPECT_EQ(error("a.obj:mirror=xx"),
            "--place: 'mirror=xx'; expected axes, such as mirror=x or mirror=xz");
}

}  // namespace
}  // namespace tessera
