#include <gtest/gtest.h>

#include "scenes/edit/vocabulary.h"
#include "tests/unit/scenes/edit/placement_testing.h"

namespace tessera::edit {
namespace {

const char* const kLux = R"(materials { name: "white" }
includes {
    file: "sphere.obj"
    transform {
        steps { translate { x: 0 y: 0 z: 0 } }
        steps { rotate { axis { x: 1 } angle: 0 } } # about x
        steps { rotate { axis { y: 1 } angle: 0 } }
        steps { rotate { axis { z: 1 } angle: 0 } }
        steps { scale { x: 1 y: 1 z: 1 } }
    }
    material: "white"
}
)";

constexpr Language kTessera = Language::tessera;

std::string placed(const std::string& text, const Placement& placement) {
  return placed(kTessera, text, placement);
}

std::string fault(const Placement& placement, const std::string& text) {
  return fault(kTessera, text, placement);
}

WrittenPlacement read_include(const std::string& text) { return read_include(kTessera, text); }

std::string with_other(std::string text, const std::string& old, const std::string& by) {
  const size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), by);
}

TEST(StudioEdit, APlacementIsReadFromItsSteps) {
  const WrittenPlacement lux = read_include(kLux);
  EXPECT_EQ(lux.locked, "");
  expect_same(lux.placement, {.file = "sphere.obj", .material = "white"});
  const WrittenPlacement some = read_include(
      "includes { file: 'a.obj' transform { steps { rotate { axis { y: 2 } angle: 45 } } "
      "steps { scale { x: -2 y: .5 z: 3 } } } }");
  expect_same(some.placement, {.file = "a.obj",
                               .material = "",
                               .rotation = {"0", "45", "0"},
                               .scale = {"2", ".5", "3"},
                               .flip = {true, false, false}});
}

TEST(StudioEdit, AnotherTransformIsNoPlacement) {
  for (const char* const steps :
       {"steps { scale { x: 1 } } steps { translate { x: 1 } }", "steps { matrix { } }",
        "steps { rotate { axis { x: 1 y: 1 } angle: 5 } }",
        "steps { rotate { axis { x: -1 } angle: 5 } }",
        "steps { translate { } } steps { translate { } }"}) {
    const std::string text = std::string("includes { file: 'a.obj' transform { ") + steps + " } }";
    EXPECT_NE(read_include(text).locked, "") << steps;
    EXPECT_NE(fault({.file = "a.obj", .material = ""}, text), "none");
  }
}

TEST(StudioEdit, APlacementChangesTheLiteralsThatDiffer) {
  Placement lux = read_include(kLux).placement;
  EXPECT_EQ(placed(kLux, lux), kLux);
  lux.position = {"0", "1.50", "0"};
  lux.rotation = {"0", "0", "30"};
  lux.flip = {false, true, false};
  lux.material = "";
  std::string wanted = with_other(kLux, "y: 0", "y: 1.50");
  wanted = with_other(wanted, "axis { z: 1 } angle: 0", "axis { z: 1 } angle: 30");
  wanted = with_other(wanted, "x: 1 y: 1 z: 1", "x: 1 y: -1 z: 1");
  wanted = with_other(wanted, "    material: \"white\"\n", "");
  EXPECT_EQ(placed(kLux, lux), wanted);
}

TEST(StudioEdit, APlacementAddsTheStepsThatItNeeds) {
  Placement some{
      .file = "a.obj", .material = "", .position = {"1", "0", "0"}, .rotation = {"0", "90", "0"}};
  std::string text = placed("includes { file: 'a.obj' }", some);
  expect_same(read_include(text).placement, some);
  some.scale = {"2", "2", "2"};
  some.flip = {true, true, true};
  text = placed(text, some);
  expect_same(read_include(text).placement, some);
  // One that others follow.
  some.rotation = {"10", "90", "0"};
  text = placed(text, some);
  expect_same(read_include(text).placement, some);
  some.file = "b.ply";
  some.material = "red";
  expect_same(read_include(placed(text, some)).placement, some);
}

TEST(StudioEdit, AFileIsAddedWithItsPlacement) {
  const Outline none = outline(Language::tessera, "nodes { }\n");
  const Placement some{.file = "a.obj", .material = "", .scale = {"2", "2", "2"}};
  const Change change = add_placement(none, some);
  ASSERT_TRUE(change.is_made());
  EXPECT_EQ(
      apply_edits(none.text(), change.edits),
      "nodes { }\nincludes { file: \"a.obj\" transform { steps { scale { x: 2 y: 2 z: 2 } } } "
      "}\n");
}

TEST(StudioEdit, RandomPlacementsComeBackFromTheMessage) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const std::string text = placed("includes { file: 'a.obj' }", random_placement(seed));
    expect_same(read_include(text).placement, random_placement(seed));
    const std::string other = placed(text, random_placement(seed + 1000));
    expect_same(read_include(other).placement, random_placement(seed + 1000));
    EXPECT_EQ(placed(other, random_placement(seed + 1000)), other);
  }
}

TEST(StudioEdit, ALanguageWithoutModelsPlacesNone) {
  const Outline obj = outline(Language::obj, "mtllib a.mtl\n");
  EXPECT_NE(read_placement(obj, 1).locked, "");
  EXPECT_FALSE(read_placement(obj, 1).has_material);
  EXPECT_FALSE(add_placement(obj, {.file = "a.obj", .material = ""}).is_made());
}

TEST(StudioEdit, WrongPlacementsAreRefused) {
  for (const char* const wrong : {"", "-", "~", "a", "nan", "inf", "1,5", "1;2"}) {
    EXPECT_NE(fault({.file = "a.obj", .material = "", .position = {wrong, "0", "0"}}, kLux), "none")
        << wrong;
    EXPECT_NE(fault({.file = "a.obj", .material = "", .rotation = {"0", wrong, "0"}}, kLux), "none")
        << wrong;
    EXPECT_NE(fault({.file = "a.obj", .material = "", .scale = {"1", "1", wrong}}, kLux), "none")
        << wrong;
  }
  EXPECT_EQ(fault({.file = "a.obj", .material = "", .scale = {"0", "1", "1"}}, kLux),
            "a scale of 0; one above 0");
  EXPECT_EQ(fault({.file = "", .material = ""}, kLux), "no file; the name of one");
}

Completions at_bar(Language language, std::string text) {
  const size_t at = text.find('|');
  text.erase(at, 1);
  return completions(outline(language, text), at);
}

TEST(StudioEdit, ProposesFilesWhereTheyFit) {
  using Files = Completions::Files;
  const Completions model = at_bar(Language::tessera, "includes { file: \"a.|obj\" }");
  EXPECT_EQ(model.files, Files::model);
  EXPECT_FALSE(model.needs_quotes);
  EXPECT_EQ(model.replaced.size(), 5u);
  const Completions picture = at_bar(Language::tessera, "textures { image { file: | } }");
  EXPECT_EQ(picture.files, Files::picture);
  EXPECT_TRUE(picture.needs_quotes);
  EXPECT_EQ(at_bar(Language::tessera, "textures { name: \"a|\" }").files, Files::none);
  EXPECT_EQ(at_bar(Language::json, "{\"includes\": [{\"file\": \"|\"}]}").files, Files::model);
  const Completions mesh = at_bar(Language::crt, "Scene { Mesh { file -> \"a.|obj\" } }");
  EXPECT_EQ(mesh.files, Files::model);
  EXPECT_FALSE(mesh.needs_quotes);
  EXPECT_EQ(mesh.replaced.size(), 5u);
  const Completions url =
      at_bar(Language::x3d, "<X3D><Scene><Inline url='\"a|.x3d\"'/></Scene></X3D>");
  EXPECT_EQ(url.files, Files::model);
  EXPECT_EQ(url.replaced.size(), 5u);
  const Completions classic = at_bar(Language::classic_x3d, "ImageTexture { url [ \"a|.png\" ] }");
  EXPECT_EQ(classic.files, Files::picture);
  EXPECT_FALSE(classic.needs_quotes);
  EXPECT_EQ(classic.replaced.size(), 5u);
  const Completions part = at_bar(Language::classic_x3d, "Inline { url | }");
  EXPECT_EQ(part.files, Files::model);
  EXPECT_TRUE(part.needs_quotes);
  EXPECT_TRUE(part.replaced.is_empty());
  const Completions second = at_bar(Language::classic_x3d, "ImageTexture { url [ \"a.png\" | ] }");
  EXPECT_EQ(second.files, Files::picture);
  EXPECT_TRUE(second.needs_quotes);
  EXPECT_TRUE(second.replaced.is_empty());
  const Completions map = at_bar(Language::mtl, "newmtl a\nmap_Kd -s 2 2 a|.png\n");
  EXPECT_EQ(map.files, Files::picture);
  EXPECT_EQ(map.replaced.size(), 5u);
}

/// What is proposed at the bar: each label, between blanks.
std::string proposed(Language language, const std::string& text) {
  std::string labels = " ";
  for (const Completion& item : at_bar(language, text).items) labels += item.label + " ";
  return labels;
}

TEST(StudioEdit, ProposesNodesAndFieldsOfTheClassicEncoding) {
  const auto has = [](const std::string& text, const std::string& label) {
    return proposed(Language::classic_x3d, text).find(" " + label + " ") != std::string::npos;
  };
  EXPECT_TRUE(has("#VRML V2.0 utf8\n|", "Shape"));
  EXPECT_TRUE(has("Shape { geometry | }", "Sphere"));
  EXPECT_FALSE(has("Shape { geometry | }", "appearance"));
  EXPECT_TRUE(has("Shape { geometry Sphere { } | }", "appearance"));
  for (const char* const list :
       {"Group { children [ | ] }", "Group { children [ Shape { } | ] }",
        "Group { children [ Shape { } # ]\n Fog { fogType \"]\" } | ] }"}) {
    EXPECT_TRUE(has(list, "Transform")) << list;
    EXPECT_FALSE(has(list, "bboxSize")) << list;
  }
  EXPECT_TRUE(has("Sphere { | }", "radius"));
  EXPECT_FALSE(has("Sphere { radius 2 | }", "radius"));
  EXPECT_TRUE(has("Sphere { radius 2 | }", "solid"));
  EXPECT_EQ(proposed(Language::classic_x3d, "Sphere { solid | }"), " FALSE TRUE ");
  EXPECT_TRUE(has("Appearance { texture ImageTexture { url \"a.png\" } material | }", "Material"));
  EXPECT_FALSE(has("Shape { appearance Appearance { } | }", "appearance"));
  for (const char* const nothing : {"Sphere { radius | }", "Text { string \"a| }", "Sphere { # | }",
                                    "Group { children [ USE | ] }"})
    EXPECT_EQ(proposed(Language::classic_x3d, nothing), " ") << nothing;
  EXPECT_EQ(proposed(Language::classic_x3d, "DEF A Shape { } Group { children [ USE | ] }"), " A ");
  EXPECT_EQ(at_bar(Language::classic_x3d, "Shape { geometry Sp| }").replaced.size(), 2u);
}

TEST(StudioEdit, ProposesStatementsOfModels) {
  EXPECT_EQ(proposed(Language::mtl, "|"), " newmtl ");
  const std::string labels = proposed(Language::mtl, "newmtl a\nKd 1 0 0\n|");
  EXPECT_NE(labels.find(" Ks "), std::string::npos);
  EXPECT_EQ(labels.find(" Kd "), std::string::npos);
  EXPECT_NE(proposed(Language::mtl, "newmtl a\nK|").find(" Kd "), std::string::npos);
  EXPECT_EQ(proposed(Language::mtl, "newmtl a\nKd |"), " ");
  EXPECT_NE(proposed(Language::obj, "v 0 0 0\n  |").find(" usemtl "), std::string::npos);
  EXPECT_EQ(proposed(Language::obj, "usemtl a\nusemtl |\nusemtl b\n"), " a b ");
  EXPECT_EQ(at_bar(Language::obj, "usemtl Material.0|01\n").replaced.size(), 12u);
}

TEST(StudioEdit, TellsWhatWordsOfModelsAndScenesMean) {
  const auto at = [](Language language, std::string text) {
    const size_t bar = text.find('|');
    text.erase(bar, 1);
    const auto made = hover(outline(language, text), bar);
    return made ? made->title + ": " + made->detail + made->help : "";
  };
  EXPECT_EQ(at(Language::classic_x3d, "Sphere { ra|dius 2 }"),
            at(Language::x3d, "<X3D><Scene><Sphere ra|dius='2'/></Scene></X3D>"));
  EXPECT_NE(at(Language::classic_x3d, "Sphere { ra|dius 2 }").find("above 0"), std::string::npos);
  EXPECT_EQ(at(Language::classic_x3d, "Shape { geometry Sph|ere { } }"), "Sphere: shape");
  EXPECT_NE(at(Language::mtl, "newmtl a\n  d| .5\n").find("opacity"), std::string::npos);
  EXPECT_EQ(at(Language::mtl, "newmtl |d\n"), "") << "a name";
  EXPECT_NE(at(Language::obj, "v 0 0 0\nf| 1 2 3\n").find("a face"), std::string::npos);
}

}  // namespace
}  // namespace tessera::edit
