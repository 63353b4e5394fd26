#include "scenes/formats/crt/crt_reader.h"
#include "scenes/import/to_affine.h"
#include "tests/unit/scenes/edit/placement_testing.h"

namespace tessera::edit {
namespace {

constexpr Language kCrt = Language::crt;

const std::string kBegin =
    "-- models\r\ncam = Camera { position -> vec3(0, 0, -5)  pointing -> vec3(0, 0, 0)  fov -> 40 "
    "}\r\nred = Material { color -> rgb(1, 0, 0) }\r\n";
const std::string kEnd = "\r\nSettings { camera -> cam }\r\n";

/// A script whose scene is that statement.
std::string script(const std::string& statement) {
  return kBegin + "Scene {\r\n    " + statement + "\r\n}" + kEnd;
}

/// The statement after it got that placement.
std::string placed_statement(const std::string& statement, const Placement& placement) {
  const std::string made = placed(kCrt, script(statement), placement);
  const std::string begin = kBegin + "Scene {\r\n    ", end = "\r\n}" + kEnd;
  EXPECT_TRUE(made.starts_with(begin) && made.ends_with(end)) << made;
  return made.substr(begin.size(), made.size() - begin.size() - end.size());
}

WrittenPlacement read_statement(const std::string& statement) {
  return read_include(kCrt, script(statement));
}

std::string fault_of(const std::string& statement, const Placement& placement) {
  return fault(kCrt, script(statement), placement);
}

TEST(CrtPlacement, IsReadFromTheModifiers) {
  const WrittenPlacement some = read_statement(
      "Mesh { file -> \"a.obj\" material -> red } <scale vec3(-2, .5, 3.), rotate vec3(0, 90, 0)> "
      "<translate vec3(1, -2.50, 0)>");
  EXPECT_EQ(some.locked, "");
  EXPECT_TRUE(some.has_material);
  expect_same(some.placement, {.file = "a.obj",
                               .material = "red",
                               .position = {"1", "-2.50", "0"},
                               .rotation = {"0", "90", "0"},
                               .scale = {"2", ".5", "3."},
                               .flip = {true, false, false}});
  expect_same(
      read_statement("Mesh { file -> \"a.obj\" } <scale -2>").placement,
      {.file = "a.obj", .material = "", .scale = {"2", "2", "2"}, .flip = {true, true, true}});
  expect_same(read_placement(outline(kCrt, script("")), 0).placement, {.file = "", .material = ""});
}

TEST(CrtPlacement, StepsAreAddedInTheirOrder) {
  const Placement none{.file = "a.obj", .material = ""};
  const std::string mesh = "Mesh { file -> \"a.obj\" }";
  EXPECT_EQ(placed_statement(mesh, none), mesh);
  Placement some = none;
  some.rotation = {"0", "90", "0"};
  EXPECT_EQ(placed_statement(mesh + " -- a", some), mesh + " <rotate vec3(0, 90, 0)> -- a");
  some.position = {"1", "+.5", "-1e-3"};
  some.scale = {"2", "2.0", "2"};
  const std::string all = " <scale 2, rotate vec3(0, 90, 0), translate vec3(1, 0.5, -0.001)>";
  EXPECT_EQ(placed_statement(mesh, some), mesh + all);
  EXPECT_EQ(placed_statement(mesh + " <rotate vec3(0, 90, 0)>", some), mesh + all);
  EXPECT_EQ(placed_statement(mesh + " <scale 2> <translate vec3(1, 0.5, -0.001)>", some),
            mesh + " <scale 2, rotate vec3(0, 90, 0)> <translate vec3(1, 0.5, -0.001)>");
  some.flip = {false, true, false};
  EXPECT_EQ(
      placed_statement(mesh, some),
      mesh + " <scale vec3(2, -2.0, 2), rotate vec3(0, 90, 0), translate vec3(1, 0.5, -0.001)>");
}

TEST(CrtPlacement, ChangesTheLiteralsThatDiffer) {
  const std::string mesh =
      "Mesh {file->\"a.obj\"}  <scale 2, rotate vec3(0,90.0,0 ), translate vec3( 1.0, 2, 3 )>";
  Placement some = read_statement(mesh).placement;
  some.position = {"1", "2", "4"};
  some.rotation = {"0", "45", "0.0"};
  EXPECT_EQ(placed_statement(mesh, some),
            "Mesh {file->\"a.obj\"}  <scale 2, rotate vec3(0,45.0,0 ), translate vec3( 1.0, 2, 4 "
            ")>");
  some = read_statement(mesh).placement;
  some.scale = {"3", "3", "3"};
  some.file = "b \"c\".ply";
  EXPECT_EQ(placed_statement(mesh, some),
            "Mesh {file->\"b \\\"c\\\".ply\"}  <scale 3, rotate vec3(0,90.0,0 ), translate vec3( "
            "1.0, 2, 3 )>");
  some = read_statement(mesh).placement;
  some.scale = {"3", "1", "3"};
  EXPECT_EQ(placed_statement(mesh, some),
            "Mesh {file->\"a.obj\"}  <scale vec3(3, 1, 3), rotate vec3(0,90.0,0 ), translate "
            "vec3( 1.0, 2, 3 )>");
}

TEST(CrtPlacement, SetsTheMaterial) {
  const std::string bare = "Mesh { file -> \"a.obj\" }";
  const std::string with = "Mesh { file -> \"a.obj\" material -> red }";
  const std::string inside =
      "Mesh { file -> \"a.obj\" material -> Material { color -> rgb(0, 0, 1) } } <scale 2>";
  Placement some{.file = "a.obj", .material = "red"};
  EXPECT_EQ(placed_statement(bare, some), with);
  EXPECT_EQ(placed_statement(with, some), with);
  some.material = "";
  EXPECT_EQ(placed_statement(with, some), bare);
  const Placement own = read_statement(inside).placement;
  EXPECT_EQ(placed_statement(inside, own), inside);
  some = own;
  some.material = "red";
  some.position[0] = "1";
  EXPECT_EQ(placed_statement(inside, some), with + " <scale 2, translate vec3(1, 0, 0)>");
  some.material = "rad";
  EXPECT_EQ(fault_of(bare, some), "'rad'; the name of a variable; did you mean 'red'?");
}

TEST(CrtPlacement, AVariableOfItsOwnIsSetWhereItIsAssigned) {
  const std::string before = "at = vec3(1, 0, 0)\n",
                    behind = "Scene { Mesh { file -> \"a.obj\" } <translate at> }\n";
  Placement some = read_include(kCrt, before + behind).placement;
  EXPECT_EQ(some.position[0], "1");
  some.position[1] = "5";
  EXPECT_EQ(placed(kCrt, before + behind, some), "at = vec3(1, 5, 0)\n" + behind);
  EXPECT_NE(read_include(kCrt, before + behind + "b = at\n").locked, "");
}

TEST(CrtPlacement, IsLockedWhereItIsNone) {
  const std::string mesh = "Mesh { file -> \"a.obj\" }";
  const std::string order =
      "its modifiers are others than scale, rotate and translate, in this order";
  const std::string several = "the script places it several times, and all of them would change";
  const auto computed = [](const std::string& step) {
    return "its " + step + " is computed, or comes from a variable that has other uses";
  };
  const std::pair<std::string, std::string> cases[] = {
      {mesh + " <translate vec3(1, 0, 0), scale 2>", order},
      {mesh + " <scale 2, scale 2>", order},
      {mesh + " <rotate vec3(1, 0, 0)> <rotate vec3(1, 0, 0)>", order},
      {mesh + " <scale 1 + 1>", computed("scale")},
      {mesh + " <scale t>", computed("scale")},
      {mesh + " <rotate vec3(0, 10 * t, 0)>", computed("rotate")},
      {mesh + " <translate vec3(+1, 0, 0)>", computed("translate")},
      {mesh + " <translate vec3(1, 0)>", computed("translate")},
      {mesh + " <translate vec3(1, 0, 0, 0)>", computed("translate")},
      {mesh + " <translate rgb(1, 0, 0)>", computed("translate")},
      {mesh + " <rotate 90>", computed("rotate")},
      {mesh + " <scale>", computed("scale")},
      {"m = " + mesh + "\n m\n m <scale 2>", several},
      {"f = Macro(a) { " + mesh + " }\n f(1) f(2)", several},
      {"i = 0 while (i < 3) { " + mesh + " i = i + 1 }", several},
      {"Mesh", "its braces are not there or not closed"},
      {"Mesh { file -> \"a\" + \"b\" }", "its file is computed: \"a\" + \"b\""}};
  for (const auto& [statement, locked] : cases) {
    SCOPED_TRACE(statement);
    EXPECT_EQ(read_statement(statement).locked, locked);
    EXPECT_EQ(fault_of(statement, {.file = "a.obj", .material = ""}), locked + "; a placement");
  }
  EXPECT_EQ(read_statement("m = " + mesh + "\n m <translate vec3(1, 0, 0), scale 2>").locked, "");
  EXPECT_EQ(read_statement("[" + mesh + "] <scale 2>").locked, "");
}

TEST(CrtPlacement, IsAddedWithItsModel) {
  const Placement some{.file = "b.obj", .material = "red", .position = {"1", "0", "0"}};
  const std::string mesh = "Mesh { file -> \"a.obj\" }";
  const std::string made = "Mesh { file -> \"b.obj\" material -> red } <translate vec3(1, 0, 0)>";
  EXPECT_EQ(added(kCrt, script(mesh), some), script(mesh + "\r\n    " + made));
  // Others stand behind it.
  EXPECT_EQ(added(kCrt, script(mesh) + "m = " + mesh, some),
            script(mesh + "\r\n    " + made) + "m = " + mesh);
}

/// What the reader makes of a script's first model; a Mesh is mirrored in z before all else.
Affine read_matrix(const std::string& text) {
  const LoadedScene read = parse_crt(text, "made.crt", {}, 0);
  EXPECT_EQ(read.scene.includes_size(), 1);
  return to_affine(read.scene.includes(0).transform()) * scaling({1, 1, -1});
}

TEST(CrtPlacement, RandomOnesComeBackAndAreWhatTheReaderMakes) {
  const std::string first = script("Mesh { file -> \"a.obj\" }");
  for (uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    std::string text = first;
    for (const uint64_t each : {seed, seed + 1000}) {
      const Placement wanted = random_placement(each);
      text = placed(kCrt, text, wanted);
      const Placement got = read_include(kCrt, text).placement;
      EXPECT_EQ(numbers_of(got.position), numbers_of(wanted.position));
      EXPECT_EQ(numbers_of(got.rotation), numbers_of(wanted.rotation));
      EXPECT_EQ(signed_numbers_of_scale(got), signed_numbers_of_scale(wanted));
      EXPECT_EQ(placed(kCrt, text, wanted), text);
      EXPECT_EQ(placed(kCrt, text, got), text);
      EXPECT_LE(largest_difference(read_matrix(text), matrix_of(wanted, false)), 1e-12) << text;
    }
    text = placed(kCrt, text, read_include(kCrt, first).placement);
    EXPECT_LE(largest_difference(read_matrix(text), Affine{}), 0.0);
  }
}

}  // namespace
}  // namespace tessera::edit
