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
  EXPECT_EQ(suggestion("1", std::vector<std::string>{"0"}), "") << "no letter of it is the same";
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

TEST(Diagnostic, HasThePartsOfTheMessage) {
  const std::array<std::string, 2> names{"whitted", "path"};
  const Error error =
      scene_error({"a.tessera", 3, 7}, "'pth'", "one of whitted, path" + suggestion("pth", names));
  EXPECT_STREQ(error.what(),
               "a.tessera:3:7: 'pth'; expected one of whitted, path; did you mean 'path'?");
  ASSERT_EQ(error.diagnostics().size(), 1u);
  const Diagnostic& parts = error.diagnostics()[0];
  EXPECT_EQ(parts.place.str(), "a.tessera:3:7");
  EXPECT_EQ(parts.found, "'pth'");
  EXPECT_EQ(parts.expected, "one of whitted, path");
  EXPECT_EQ(parts.suggestion, "path");
  EXPECT_EQ(parts.end.line, 0);
}

TEST(Diagnostic, HasThePartsOfAMessageThatWasPutTogetherElsewhere) {
  const Diagnostic built =
      scene_error({"a.obj"}, "sphere.radius: -1; expected above 0", "").diagnostics().at(0);
  EXPECT_EQ(built.found, "sphere.radius: -1");
  EXPECT_EQ(built.expected, "above 0");
  const Diagnostic missing = make_diagnostic({"a.obj"}, "no such file; did you mean 'b.obj'?", "");
  EXPECT_EQ(missing.found, "no such file");
  EXPECT_EQ(missing.suggestion, "b.obj");
  EXPECT_TRUE(usage_error("what?").diagnostics().empty());
}

TEST(Diagnostic, EndsWithTheWordAtItsPlace) {
  const std::string text = "one two.three\r\n\"a \\\" b\" -1.5e-3,x\n\n{ ünd";
  const auto end = [&](int line, int column) {
    const SourcePlace at = end_of_word(text, {"a", line, column});
    return at.line == 0 ? 0 : at.column;
  };
  EXPECT_EQ(end(1, 1), 4);
  EXPECT_EQ(end(1, 5), 14) << "a name with a dot";
  EXPECT_EQ(end(1, 14), 14) << "the end of a line";
  EXPECT_EQ(end(2, 1), 9) << "a text in quotes";
  EXPECT_EQ(end(2, 10), 17) << "a number";
  EXPECT_EQ(end(2, 17), 18) << "one character";
  EXPECT_EQ(end(3, 1), 1);
  EXPECT_EQ(end(4, 3), 7) << "in bytes";
  EXPECT_EQ(end(5, 1), 0);
  EXPECT_EQ(end(1, 99), 0);
  EXPECT_EQ(end(0, 0), 0);
}

}  // namespace
}  // namespace tessera
