#include <gmock/gmock.h>

#include "scenes/formats/crt/crt_lexer.h"
#include "scenes/formats/crt/java_random.h"
#include "tests/unit/scenes/formats/crt/crt_support.h"

namespace tessera::crt_test {
namespace {

using testing::HasSubstr;

TEST(CrtLanguage, NumbersAreWrittenAsInTheOriginal) {
  EXPECT_EQ(number("162."), 162);
  EXPECT_EQ(number(".5"), .5);
  EXPECT_EQ(number("0.25"), .25);
  EXPECT_EQ(number("162./255"), 162. / 255);
}

TEST(CrtLanguage, CommentsReachToTheEndOfTheLine) {
  EXPECT_EQ(number("3--2\n"), 3);
  EXPECT_EQ(number("3 - -2"), 5);
}

TEST(CrtLanguage, IntegersStayIntegersAndFloatsWin) {
  EXPECT_EQ(number("7 / 2"), 3);
  EXPECT_EQ(number("0 - (-7) / 2"), 3);
  EXPECT_EQ(number("7 / 2.0"), 3.5);
  EXPECT_EQ(number("7 % 4"), 3);
  EXPECT_EQ(number("7.5 % 2"), 1.5);
  EXPECT_EQ(number("-7 % 4 + 10"), 7);
  EXPECT_EQ(number("(2147483647 + 1) / -2147483647"), 1);  // wraps as Java's int
}

TEST(CrtLanguage, OperatorsBindAsInTheGrammar) {
  EXPECT_EQ(number("1 + 2 * 3"), 7);
  EXPECT_EQ(number("10 - 4 - 3"), 3);
  EXPECT_EQ(number("-2 * -3"), 6);
  EXPECT_EQ(number("- - 2"), 2);
  EXPECT_TRUE(truth("1 + 1 == 2"));
  EXPECT_TRUE(truth("true || false && false"));
  EXPECT_TRUE(truth("!false == true"));
  EXPECT_EQ(number("false ? 1 : true ? 2 : 3"), 2);
  EXPECT_EQ(number("2 > 1 ? 5 : 6"), 5);
}

TEST(CrtLanguage, EqualIsOfOneTypeAndValue) {
  EXPECT_FALSE(truth("1 == 1.0"));
  EXPECT_TRUE(truth("1 != 1.0"));
  EXPECT_TRUE(truth("\"a\" == \"a\""));
  EXPECT_TRUE(truth("[1, [2, 3]] == [1, [2, 3]]"));
  EXPECT_FALSE(truth("[1, 2] == [1, 2.0]"));
  EXPECT_TRUE(truth("vec3(1, 2, 3) == vec3(1, 2, 3)"));
}

TEST(CrtLanguage, TextsJoinAndRepeat) {
  EXPECT_EQ(text("\"a\" + 1 + 2.0 + true"), "a12.0true");
  EXPECT_EQ(text("3 * \"ab\""), "ababab");
  // Floats as Java writes them.
  EXPECT_EQ(text("\"\" + 100000000.0"), "1.0E8");
  EXPECT_EQ(text("\"\" + 1234567.5"), "1234567.5");
  EXPECT_EQ(text("\"\" + 10000000.0"), "1.0E7");
  EXPECT_EQ(text("\"\" + .001"), "0.001");
  EXPECT_EQ(text("\"\" + -.00015"), "-1.5E-4");
  EXPECT_EQ(text("\"say \\\"hi\\\"\\t\\u00e9\""), "say \"hi\"\t\u00e9");
}

TEST(CrtLanguage, ALineThatBeginsWithAnOperatorGoesOn) {
  EXPECT_EQ(number("5\n- 2"), 3);
  EXPECT_EQ(number("[4, 5]\n[1]"), 5);
  const v1::Scene scene = scene_of("a = " + sphere("1") + "b = " + sphere("2"), "a\n- b");
  ASSERT_EQ(scene.nodes_size(), 1);
  EXPECT_EQ(scene.nodes(0).shape().csg().operation(), v1::Csg::DIFFERENCE);
}

TEST(CrtLanguage, AnAliasSeesLaterChangesOutsideOfBlocks) {
  EXPECT_EQ(number("a", "b = 1\na = b\nb = 2"), 2);
  EXPECT_EQ(number("a", "b = 1\na = b + 0\nb = 2"), 1);
  EXPECT_EQ(number("a + b", "a = b = 2"), 4);
  EXPECT_EQ(number("a", "a = 7\nb = 1\na = b\nb = 2"), 1);  // not left dangling
  EXPECT_EQ(number("a", "a = 1\nb = a\na = b\n"), 1);       // no way round in a circle
  EXPECT_EQ(number("a", "b = 1\na = 0\nif (true) { c = b\n b = 2\n a = c }"), 1);
}

TEST(CrtLanguage, VectorsColoursAndListsCompute) {
  EXPECT_EQ(number("(vec3(1, 2, 3) + 2 * vec3(1, 1, 1))[2]"), 5);
  EXPECT_EQ(number("(-vec3(1, -2, 3) / 2)[1]"), 1);
  EXPECT_EQ(number("(rgb(1, .5, 0) * rgb(1, .5, 1))[1]"), .25);
  EXPECT_EQ(number("([1, 2] + [3])[2]"), 3);
  EXPECT_EQ(number("[[1, 2], [3, 4]][1][0]"), 3);
  EXPECT_EQ(number("[1, 2][4 / 4.]"), 2);
  EXPECT_EQ(number("length([1, 2, 3])"), 3);
  EXPECT_EQ(number("length(vec3(3, 4, 0))"), 5);
}

TEST(CrtLanguage, FunctionsTakeIntegersToo) {
  EXPECT_EQ(number("cos(0)"), 1);
  EXPECT_EQ(number("max(1, 2)"), 2);
  EXPECT_EQ(number("pow(-2, 2)"), 4);
  EXPECT_EQ(number("int(2.9)"), 2);
  EXPECT_EQ(number("float(3) / 2"), 1.5);
  EXPECT_EQ(number("sin(3.14159265358979 / 2)"), 1);
}

TEST(CrtLanguage, RandomNumbersAreJavas) {
  // The first numbers of new java.util.Random(42).nextDouble(), as Java's documentation defines it.
  JavaRandom random(42);
  EXPECT_DOUBLE_EQ(random.next_double(), 0.7275636800328681);
  EXPECT_DOUBLE_EQ(random.next_double(), 0.6832234717598454);
  JavaRandom script_random(1337);
  const double first = script_random.next_double(), second = script_random.next_double();
  EXPECT_EQ(number("rand(0.0, 1.0)"), first);
  EXPECT_EQ(number("b", "a = rand(0, 1)\nb = rand(4, 2)"), 2 + 2 * second);
}

TEST(CrtLanguage, OutsideOfBlocksBothSidesAreEvaluated) {
  JavaRandom random(1337);
  random.next_double();
  random.next_double();
  const double third = random.next_double();
  EXPECT_EQ(number("rand(0, 1)", "a = true ? rand(0, 1) : rand(0, 1)"), third);
  random = JavaRandom(1337);
  random.next_double();
  EXPECT_EQ(number("rand(0, 1)", "if (true) { a = true ? rand(0, 1) : rand(0, 1) }"),
            random.next_double());
}

TEST(CrtLanguage, TimeIsTheFrame) {
  EXPECT_EQ(number("t + 1"), 1);
  EXPECT_EQ(number("t * 0.5", "", 7), 3.5);
  EXPECT_TRUE(read(script("a = t")).depends_on_frame);
  EXPECT_FALSE(read(script("a = 1")).depends_on_frame);
}

TEST(CrtLanguage, MacrosHaveParametersScopesAndRecursion) {
  EXPECT_EQ(number("f(20)", "f = Macro(n) { n < 2 ? 1 : n + f(n - 1) }"), 210);
  EXPECT_EQ(number("x", "x = 1\nf = Macro(x) { x = x + 5\n x }\ny = f(3)"), 1);
  EXPECT_EQ(number("f(2)", "k = 10\nf = Macro(x) { k * x }"), 20);
  EXPECT_EQ(number("f(2)(3)", "f = Macro(a) { Macro(b) { 10 * a + b } }"), 23);
  EXPECT_EQ(number("length(f())", "f = Macro() { 1 2 3 }"), 3);
}

TEST(CrtLanguage, LoopsAndBranches) {
  const std::string sum = "s = 0\ni = 1\nwhile (i <= 100) { s = s + i\n i = i + 1 }";
  EXPECT_EQ(number("s", sum), 5050);
  EXPECT_EQ(number("s", "s = 0\nIf (1 > 2) { s = 1 } else if (2 > 1) { s = 2 } else { s = 3 }"), 2);
  EXPECT_EQ(number("s", "s = 1\nif (true) { s = 2\n u = 3 }"), 2);
  EXPECT_THAT(complaint_of("if (true) { u = 3 }\nv = u"), HasSubstr("unknown variable 'u'"));
}

TEST(CrtLanguage, WordsOfBlocksAreNamesElsewhere) {
  EXPECT_EQ(number("while + if", "while = 1\nif = 2"), 3);
}

TEST(CrtLanguage, SceneGathersFromMacrosLoopsAndLists) {
  const std::string row =
      "row = Macro(n) { i = 0 while (i < n) { Sphere { center -> vec3(i, 0, 0) radius -> 1 "
      "material -> m } i = i + 1 } }";
  EXPECT_EQ(scene_of(row, "row(4)").nodes_size(), 4);
  EXPECT_EQ(scene_of(row, "[row(2), [row(1)]]\nif (true) { row(3) }").nodes_size(), 6);
  EXPECT_EQ(scene_of(row, "row(3)").nodes(2).shape().sphere().center().x(), 2);
}

}  // namespace
}  // namespace tessera::crt_test
