#include <gmock/gmock.h>

#include <chrono>

#include "tests/unit/scenes/formats/crt/crt_support.h"

namespace tessera::crt_test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(CrtErrors, ShowPlaceSourceAndCaret) {
  EXPECT_EQ(complaint("a = 1 +\n  b = Sphre { radius -> 1 }\nc = )"),
            "x.crt:1:7: a value that cannot be assigned to; expected a name before '='\n"
            "    1 | a = 1 +\n"
            "      |       ^\n"
            "x.crt:3:5: ')'; expected a value\n"
            "    3 | c = )\n"
            "      |     ^\n"
            "2 errors");
}

TEST(CrtErrors, AreValuesToo) {
  try {
    parse_crt("a = 1\nb = rgbb(1, 1, 1)\nc = \"ü\" + camm\n", "x.crt", std::nullopt, 0);
    ADD_FAILURE() << "two things are wrong";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("x.crt:3:11: "));
    ASSERT_GE(error.diagnostics().size(), 2u) << error.what();
    const Diagnostic &first = error.diagnostics()[0], &second = error.diagnostics()[1];
    EXPECT_EQ(first.place.str(), "x.crt:2:5");
    EXPECT_EQ(first.suggestion, "rgb");
    EXPECT_EQ(second.place.str(), "x.crt:3:12") << "in bytes";
    EXPECT_EQ(second.end.column, 16);
  }
}

TEST(CrtErrors, SuggestTheNearestName) {
  EXPECT_THAT(complaint_of("b = Sphre { }"), HasSubstr("did you mean 'Sphere'?"));
  EXPECT_THAT(complaint_of("b = camm"), HasSubstr("did you mean 'cam'?"));
  EXPECT_THAT(complaint_of("b = rgbb(1, 1, 1)"), HasSubstr("did you mean 'rgb'?"));
  EXPECT_THAT(complaint_of("", "Sphere { center -> vec3(0,0,0) raduis -> 1 material -> m }"),
              HasSubstr("did you mean 'radius'?"));
  EXPECT_THAT(complaint_of("c = Camera { position -> vec3(0,0,0) pointing -> vec3(0,0,1) "
                           "fov -> 45 apertureshape -> \"pentagn\" }"),
              HasSubstr("did you mean 'pentagon'?"));
}

TEST(CrtErrors, SeveralInOneRunAndNoneThatOnlyFollows) {
  const std::string all =
      complaint_of("a = Sphere { center -> 1 radius -> \"x\" material -> m }", "a\na - a\nb");
  EXPECT_THAT(all, HasSubstr("center is the integer 1; expected a vector"));
  EXPECT_THAT(all, HasSubstr("radius is the text \"x\"; expected a number"));
  EXPECT_THAT(all, HasSubstr("unknown variable 'b'"));
  EXPECT_THAT(all, HasSubstr("\n3 errors"));
}

TEST(CrtErrors, AnAliasOfNothingIsNone) {
  EXPECT_THAT(complaint_of("y = x\nx = y\nz = x + y"), HasSubstr("unknown variable 'x'"));
  EXPECT_THAT(complaint_of("x = x"), HasSubstr("unknown variable 'x'"));
}

TEST(CrtErrors, StopAtTwenty) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "a" + std::to_string(i) + " = 1 + true\n";
  EXPECT_THAT(complaint_of(text), HasSubstr("20 errors; the rest is not looked at"));
}

TEST(CrtErrors, UnknownAttributesAreWarnings) {
  const LoadedScene loaded =
      read(script("n = Material { color -> rgb(1,1,1) reflectivty -> 0.5 }"));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_EQ(loaded.warnings[0],
            "x.crt:3:36: Material has no attribute 'reflectivty', which is left out; did you mean "
            "'reflectivity'?");
}

TEST(CrtErrors, WhatIsNeededIsAskedFor) {
  EXPECT_THAT(complaint("a = 1"), HasSubstr("a script without Settings"));
  EXPECT_THAT(complaint("Settings { } Scene { }"), HasSubstr("Settings without 'camera'"));
  EXPECT_THAT(complaint(kCamera + "Settings { camera -> cam }"),
              HasSubstr("a script without Scene"));
  EXPECT_THAT(complaint(kCamera + "cam\nSettings { camera -> cam } Scene { }"),
              HasSubstr("by itself"));
  EXPECT_THAT(complaint(""), HasSubstr("a script without Settings"));
}

TEST(CrtErrors, TypesAreNamed) {
  EXPECT_THAT(complaint_of("a = 1 + cam"), HasSubstr("'+' between the integer 1 and a camera"));
  EXPECT_THAT(complaint_of("a = 1 / 0"), HasSubstr("divided by 0"));
  EXPECT_THAT(complaint_of("a = [1][1]"), HasSubstr("the index 1; expected 0 to 0"));
  EXPECT_THAT(complaint_of("a = 3[0]"), HasSubstr("an index into the integer 3"));
  EXPECT_THAT(complaint_of("a = 99999999999"), HasSubstr("an integer that is too large"));
  EXPECT_THAT(complaint_of("a = m(1)"), HasSubstr("'m' is a material"));
  EXPECT_THAT(complaint_of("f = Macro(a) { a }\nb = f()"), HasSubstr("expected 1"));
  EXPECT_THAT(complaint_of("a = vec3(1, 2)"), HasSubstr("vec3 with 2 arguments; expected 3"));
  EXPECT_THAT(complaint_of("", sphere("-1")), HasSubstr("of at least 0"));
  EXPECT_THAT(complaint_of("", sphere("1.0 / 0")), HasSubstr("radius is the float Infinity"));
}

TEST(CrtErrors, RecoveryKeepsToTheBraces) {
  const std::string all =
      complaint(kCamera +
                "a = Sphere { center -> vec3(0 0, 0) radius -> ) }\nb = 1 1 = 2\n"
                "Settings { camera -> cam }\nScene { a Settings { } }\n");
  EXPECT_THAT(all, HasSubstr("x.crt:2:31:"));
  EXPECT_THAT(all, HasSubstr("x.crt:2:47:"));
  EXPECT_THAT(all, HasSubstr("x.crt:3:7:"));
  EXPECT_THAT(all, HasSubstr("x.crt:5:11:"));
}

TEST(CrtErrors, BrokenTextEndsWithAMessage) {
  for (const char* text : {"{", "}", "Scene {", "a = \"x", "a = [1,", "Settings { camera ->",
                           "Sphere", "Macro", "a = Macro(", "while (", "if (true) {", "<", "é",
                           "a = b < scale", "a <scale", "else", "Scene", "-> -> ->", "\x01\x02"}) {
    EXPECT_NE(complaint(text), "") << text;
  }
  const std::string whole = script("f = Macro(a) { while (a < 3) { a = a + 1 } }",
                                   "Sphere { center -> vec3(0, 0, 0) radius -> 1 material -> m }");
  for (size_t length = 0; length + 3 < whole.size(); ++length)
    EXPECT_NE(complaint(whole.substr(0, length)), "") << length;
}

std::string repeat(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(CrtLimits, DeepNestingIsReadOrRefused) {
  EXPECT_EQ(number(repeat("(", 1000) + "1" + repeat(")", 1000)), 1);
  for (const auto& [open, close] :
       std::vector<std::pair<std::string, std::string>>{{"(", ")"},
                                                        {"[", "]"},
                                                        {"- ", ""},
                                                        {"true ? 1 : ", ""},
                                                        {"a = ", ""},
                                                        {"Box { cornerA -> ", "}"},
                                                        {"f(", ")"},
                                                        {"Macro() {", "}"},
                                                        {"Union {", "}"}}) {
    EXPECT_THAT(complaint_of("a = " + repeat(open, 100000) + "1" + repeat(close, 100000)),
                HasSubstr("nested too deep"))
        << open;
  }
  EXPECT_THAT(complaint_of(repeat("if (true) {", 100000)), HasSubstr("nested too deep"));
}

TEST(CrtLimits, LongChainsAreNoNesting) {
  EXPECT_EQ(number("0" + repeat(" + 1", 100000)), 100000);
  EXPECT_EQ(number("1" + repeat(" * 1.0", 100000)), 1);
}

TEST(CrtLimits, NothingRunsForEver) {
  EXPECT_THAT(complaint_of("i = 0 while (true) { i = i + 1 }"), HasSubstr("a loop without end"));
  EXPECT_THAT(complaint_of("i = 0 while (true) { j = 0 while (j < 1000) { j = j + 1 } }"),
              HasSubstr("runs too long"));
  EXPECT_THAT(complaint_of("f = Macro(n) { f(n + 1) }\na = f(0)"),
              HasSubstr("macros call each other too deep"));
  EXPECT_THAT(complaint_of("f = Macro(n) { f(n) f(n) }\na = f(0)"),
              HasSubstr("macros call each other too deep"));
}

TEST(CrtLimits, NothingGrowsForEver) {
  const std::string doubling = "i = 0 while (i < 64) { a = a + a i = i + 1 }";
  EXPECT_THAT(complaint_of("a = \"x\"\n" + doubling), HasSubstr("too much memory"));
  EXPECT_THAT(complaint_of("a = [1]\n" + doubling), HasSubstr("too much memory"));
  EXPECT_THAT(complaint_of("a = " + sphere("1") + doubling), HasSubstr("too many parts"));
  EXPECT_THAT(complaint_of("a = 2000000000 * \"ab\""), HasSubstr("too much memory"));
  EXPECT_THAT(complaint_of("a = [1] b = [1] i = 0\n"
                           "while (i < 90) { a = [a, a] b = [b, b] i = i + 1 }\nc = a == b"),
              HasSubstr("too much memory"));
  EXPECT_THAT(complaint_of("s = " + sphere("1"), "i = 0 while (i < 400000) { s i = i + 1 }"),
              HasSubstr("too many entities"));
}

TEST(CrtLimits, SetOperationsNestOnlySoFar) {
  const std::string s = "s = " + sphere("1");
  EXPECT_THAT(complaint_of(s + "a = s i = 0 while (i < 100) { a = s - (a ^ s) i = i + 1 }", "a"),
              HasSubstr("set operations nested too deep"));
  // A chain of one operation does not nest.
  const v1::Scene scene = scene_of(s + "a = s i = 0 while (i < 5000) { a = a + s i = i + 1 }", "a");
  EXPECT_EQ(scene.nodes(0).shape().csg().operands_size(), 5001);
}

}  // namespace
}  // namespace tessera::crt_test
