#include "scenes/formats/x3d/x3d_reader.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/math/transform.h"
#include "scenes/import/warnings.h"
#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

std::string document(const std::string& scene, const std::string& version = "3.3") {
  return "<X3D version='" + version + "'><Scene>\n" + scene + "</Scene></X3D>";
}

LoadedScene read_x3d_scene(const std::string& scene, const ReadOptions& options = {},
                           const std::string& version = "3.3") {
  return parse_x3d(document(scene, version), "t.x3d", options);
}

std::string x3d_error(const std::string& scene) {
  return error_of([&] { read_x3d_scene(scene); });
}

TEST(X3d, SaysThatATextIsInUtf16) {
  std::string low, high;
  for (const char c : document("")) low += {c, '\0'}, high += {'\0', c};
  for (const std::string& text : {"\xFF\xFE" + low, "\xFE\xFF" + high, low, high})
    EXPECT_EQ(
        error_of([&] { parse_x3d(text, "t.x3d", {}); }),
        "t.x3d:1:1: text in UTF-16; expected UTF-8, as `iconv -f UTF-16 -t UTF-8` makes of it");
}

std::string shape(const std::string& geometry, const std::string& material = "<Material/>") {
  return "<Shape><Appearance>" + material + "</Appearance>" + geometry + "</Shape>\n";
}

/// The matrix of a transform's steps.
Affine matrix(const v1::Transform& transform) {
  Affine out;
  for (const auto& step : transform.steps()) {
    if (step.has_translate())
      out = out * translation({step.translate().x(), step.translate().y(), step.translate().z()});
    if (step.has_scale())
      out = out * scaling({step.scale().x(), step.scale().y(), step.scale().z()});
    if (step.has_rotate())
      out = out *
            rotation({step.rotate().axis().x(), step.rotate().axis().y(), step.rotate().axis().z()},
                     step.rotate().angle() * 3.14159265358979323846 / 180);
  }
  return out;
}

constexpr const char* kCube =
    "<IndexedFaceSet DEF='Cube' %s coordIndex='0 1 3 2 -1 4 6 7 5 -1 0 4 5 1 -1 2 3 7 6 -1 "
    "0 2 6 4 -1 1 5 7 3 -1'><Coordinate point='0 0 0, 0 0 1, 0 1 0, 0 1 1, 1 0 0, 1 0 1, 1 1 0, "
    "1 1 1'/></IndexedFaceSet>";

std::string cube(const std::string& fields) {
  std::string text = kCube;
  return text.replace(text.find("%s"), 2, fields);
}

std::vector<float> normals(const LoadedScene& loaded) {
  return blob_values<float>(loaded.scene.nodes(0).shape().mesh().normals(), loaded.blobs);
}

TEST(X3d, ListsTheFirstOfManyUnknownNodes) {
  std::string nodes;
  for (int i = 0; i < 20000; ++i) nodes += "<Shap" + std::to_string(i) + "/><Strange/>";
  const std::vector<std::string> warnings = read_x3d_scene(nodes).warnings;
  ASSERT_EQ(warnings.size(), Warnings::kMostEntries + 1);
  EXPECT_EQ(warnings[0], "t.x3d:2:2: unknown node 'Shap0' is left out; did you mean 'Shape'?");
  EXPECT_EQ(warnings[1], "t.x3d:2:10: unknown node 'Strange' is left out (20000 times)");
}

TEST(X3d, HasAViewpointAndAHeadlightWithoutSayingSo) {
  const LoadedScene loaded = read_x3d_scene("");
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  const v1::Camera& camera = loaded.scene.cameras(0);
  EXPECT_TRUE(camera.frame_all());
  EXPECT_TRUE(camera.world_from_camera().steps(0).has_look_at());
  EXPECT_EQ(camera.perspective().field_of_view(), 45);
  EXPECT_EQ(camera.headlight().directional().direction().z(), -1);
  EXPECT_FALSE(
      read_x3d_scene("<NavigationInfo headlight='false'/>").scene.cameras(0).has_headlight());
  EXPECT_EQ(loaded.scene.settings().output().transfer(), v1::Output::DISPLAY);
  EXPECT_EQ(loaded.scene.settings().integrator().shadows(), v1::IntegratorSettings::SHADOWS_ON);
}

TEST(X3d, SpansTheSmallerSideWithTheFieldOfView) {
  const LoadedScene loaded = read_x3d_scene(
      "<Transform translation='1 0 0'><Viewpoint DEF='V' position='0 2 0' fieldOfView='0.7854' "
      "orientation='0 1 0 1.5707963'/></Transform><Viewpoint description='second'/>");
  ASSERT_EQ(loaded.scene.cameras_size(), 2);
  const v1::Camera& camera = loaded.scene.cameras(0);
  EXPECT_EQ(camera.name(), "V");
  EXPECT_NEAR(camera.perspective().field_of_view(), 45, 1e-3);
  EXPECT_EQ(camera.perspective().axis(), v1::Perspective::SMALLER);
  const Affine m = matrix(camera.world_from_camera());
  EXPECT_NEAR(m(Point3{}).x, 1, 1e-12);
  EXPECT_NEAR(m(Point3{}).y, 2, 1e-12);
  EXPECT_NEAR(m(Vec3{0, 0, -1}).x, -1, 1e-6);
}

TEST(X3d, ComposesEveryFieldOfATransform) {
  const LoadedScene loaded = read_x3d_scene(
      "<Transform translation='1 2 3' rotation='1 2 -1 0.7' scale='1 2 4' "
      "scaleOrientation='0 3 1 1.1' center='-1 0.5 2'/>");
  const Affine c = translation({-1, .5, 2}), back = translation({1, -.5, -2});
  const Affine expected = translation({1, 2, 3}) * c * rotation({1, 2, -1}, .7) *
                          rotation({0, 3, 1}, 1.1) * scaling({1, 2, 4}) *
                          rotation({0, 3, 1}, -1.1) * back;
  const Affine got = matrix(loaded.scene.nodes(0).transform());
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_NEAR(got.m[row][column], expected.m[row][column], 1e-12) << row << ' ' << column;
}

TEST(X3d, MapsTheMaterialToTheClassicTerms) {
  const LoadedScene loaded = read_x3d_scene(
      shape("<Sphere radius='2'/>",
            "<Material diffuseColor='.5 .25 1' ambientIntensity='.5' specularColor='1 0 0' "
            "emissiveColor='0 0 .125' shininess='.5' transparency='.25'/>"));
  const v1::Material& material = loaded.scene.materials(0);
  const v1::Classic& c = material.classic();
  EXPECT_EQ(c.ambient().value().r(), .5);
  EXPECT_EQ(c.ambient().value().b(), .5);
  EXPECT_TRUE(c.ambient_times_diffuse());  // also where a texture or vertex colours give it
  EXPECT_EQ(c.diffuse().value().g(), .25);
  EXPECT_EQ(c.specular().value().r(), 1);
  EXPECT_EQ(c.emission().value().b(), .125);
  EXPECT_EQ(c.shininess().value(), 64);
  EXPECT_EQ(c.transparency().value(), .25);
  EXPECT_EQ(c.transmission(), v1::Classic::STRAIGHT);
  EXPECT_EQ(material.sides(), v1::Material::FRONT_ONLY);
  EXPECT_EQ(loaded.scene.nodes(0).shape().sphere().radius(), 2);
}

TEST(X3d, IsUnlitWithoutAMaterialAndTwoSidedWhereNotSolid) {
  const LoadedScene loaded = read_x3d_scene("<Shape><Box size='2 4 6' solid='false'/></Shape>");
  const v1::Material& material = loaded.scene.materials(0);
  EXPECT_EQ(material.unlit().color().value().g(), 1);
  EXPECT_EQ(material.sides(), v1::Material::TWO_SIDED);
  EXPECT_EQ(loaded.scene.nodes(0).shape().box().max().z(), 3);
  EXPECT_EQ(loaded.scene.nodes(0).shape().box().min().y(), -2);
}

TEST(X3d, DecodesColoursWhereAskedTo) {
  ReadOptions options;
  options.x3d_color = ReadOptions::Color::linear;
  const LoadedScene loaded =
      read_x3d_scene(shape("<Sphere/>", "<Material diffuseColor='.5 0 1'/>"), options);
  EXPECT_NEAR(loaded.scene.materials(0).classic().diffuse().value().r(), .21404, 1e-5);
  EXPECT_EQ(loaded.scene.settings().output().transfer(), v1::Output::SRGB);
}

TEST(X3d, ReadsTheThreeLights) {
  const LoadedScene loaded = read_x3d_scene(
      "<DirectionalLight direction='0 -1 0' intensity='.5' color='1 .5 0'/>"
      "<PointLight location='1 2 3' attenuation='0 0 1' radius='7' ambientIntensity='.25'/>"
      "<SpotLight beamWidth='.2' cutOffAngle='.6' on='false'/><SpotLight/>");
  const v1::Light& sun = loaded.scene.nodes(0).light();
  EXPECT_EQ(sun.directional().direction().y(), -1);
  EXPECT_EQ(sun.intensity(), .5);
  EXPECT_TRUE(sun.scoped());
  EXPECT_FALSE(sun.has_attenuation());
  EXPECT_EQ(sun.radius(), 0);
  const v1::Light& point = loaded.scene.nodes(1).light();
  EXPECT_FALSE(point.scoped());
  EXPECT_EQ(point.attenuation().quadratic(), 1);
  EXPECT_TRUE(point.attenuation().at_most_one());
  EXPECT_EQ(point.radius(), 7);
  EXPECT_EQ(point.ambient_intensity(), .25);
  const v1::Light& spot = loaded.scene.nodes(2).light();
  EXPECT_TRUE(spot.off());
  EXPECT_NEAR(spot.spot().beam_width(), .2 * 180 / 3.14159265358979, 1e-9);
  EXPECT_NEAR(spot.spot().cut_off(), .6 * 180 / 3.14159265358979, 1e-9);
  EXPECT_NEAR(loaded.scene.nodes(3).light().spot().beam_width(), 45, 1e-3);
  EXPECT_NEAR(read_x3d_scene("<SpotLight/>", {}, "4.0").scene.nodes(0).light().spot().beam_width(),
              33.75, 1e-3);
}

TEST(X3d, ReadsBackgroundsAsColourGradientOrRings) {
  EXPECT_EQ(read_x3d_scene("<Background skyColor='.25 0 0'/>").scene.background().solid().r(), .25);
  const v1::Background two =
      read_x3d_scene("<Background skyColor='0 0 1' groundColor='0 1 0'/>").scene.background();
  EXPECT_EQ(two.gradient().sky().b(), 1);
  EXPECT_EQ(two.gradient().ground().g(), 1);
  const LoadedScene rings = read_x3d_scene(
      "<Background skyColor='1 0 0, 0 0 1' skyAngle='1.5707963' groundColor='0 0 0 1 1 1 0 1 0' "
      "groundAngle='1 1'/><Background skyColor='1 1 1'/>");
  const v1::Background::Rings& r = rings.scene.background().rings();
  ASSERT_EQ(r.sky_angles_size(), 1);
  EXPECT_NEAR(r.sky_angles(0), 90, 1e-5);
  ASSERT_EQ(r.ground_size(), 3);
  EXPECT_LT(r.ground_angles(0), r.ground_angles(1));
  EXPECT_NEAR(r.ground_angles(1), 180 / 3.14159265358979, 1e-9);
}

TEST(X3d, SharesWhatIsUsedAgain) {
  const LoadedScene loaded =
      read_x3d_scene("<Group DEF='G'>" + shape("<Sphere/>") +
                     "</Group><Transform translation='3 0 0'><Group USE='G'/>"
                     "</Transform>");
  ASSERT_EQ(loaded.scene.objects_size(), 1);
  EXPECT_EQ(loaded.scene.objects(0).name(), "G");
  EXPECT_EQ(loaded.scene.nodes(0).instance_of(), "G");
  EXPECT_EQ(loaded.scene.nodes(1).children(0).instance_of(), "G");
  EXPECT_EQ(loaded.scene.materials_size(), 1);
}

TEST(X3d, ShowsOneChildOfASwitchAndNeverAProxy) {
  const std::string two = shape("<Sphere/>") + shape("<Box/>");
  EXPECT_EQ(read_x3d_scene("<Switch>" + two + "</Switch>").scene.nodes(0).children_size(), 0);
  const LoadedScene one = read_x3d_scene("<Switch whichChoice='1'>" + two + "</Switch>");
  ASSERT_EQ(one.scene.nodes(0).children_size(), 1);
  EXPECT_TRUE(one.scene.nodes(0).children(0).shape().has_box());
  EXPECT_TRUE(
      read_x3d_scene("<LOD>" + two + "</LOD>").scene.nodes(0).children(0).shape().has_sphere());
  EXPECT_EQ(read_x3d_scene("<Collision><Shape containerField='proxy'><Box/></Shape></Collision>")
                .scene.nodes(0)
                .children_size(),
            0);
}

TEST(X3d, SmoothsFacesBelowTheCreaseAngle) {
  EXPECT_TRUE(normals(read_x3d_scene(shape(cube("")))).empty());
  const LoadedScene smooth = read_x3d_scene(shape(cube("creaseAngle='1.6'")));
  const auto n = normals(smooth);
  ASSERT_EQ(n.size(), 24u);
  const float third = 1 / std::sqrt(3.f);
  for (const float component : n) EXPECT_NEAR(std::abs(component), third, 1e-6);
  // Every corner of a face has that face's normal: as flat as with 0.
  const LoadedScene flat = read_x3d_scene(shape(cube("creaseAngle='1.5'")));
  const auto f = normals(flat);
  ASSERT_EQ(f.size(), 72u);
  for (size_t i = 0; i < f.size(); i += 3)
    EXPECT_EQ(std::abs(f[i]) + std::abs(f[i + 1]) + std::abs(f[i + 2]), 1.f);
}

TEST(X3d, WeldsNearPointsForNormals) {
  // A fold of 90 degrees whose faces have points of their own, nearly the same.
  const std::string fold = shape(
      "<IndexedFaceSet creaseAngle='3.2' coordIndex='0 1 2 -1 3 4 5'><Coordinate point='"
      "0 0 0 1 0 0 0 1 0  0 0 0.001 0 1 0.001 0 0 1'/></IndexedFaceSet>");
  const auto smooth_corners = [&](double weld) {
    ReadOptions options;
    options.x3d_weld = weld;
    const auto n = normals(read_x3d_scene(fold, options));
    int count = 0;
    for (size_t i = 0; i < n.size(); i += 3) count += n[i] != 0 && n[i + 2] != 0;
    return count;
  };
  EXPECT_EQ(smooth_corners(0), 0);
  EXPECT_EQ(smooth_corners(0.0009), 0);
  EXPECT_EQ(smooth_corners(0.0011), 4);  // two of each face
}

TEST(X3d, TurnsClockwiseFacesOver) {
  const auto triangles = [](const char* ccw) {
    const LoadedScene loaded = read_x3d_scene(
        shape("<IndexedTriangleSet normalPerVertex='false' ccw='" + std::string(ccw) +
              "' index='0 1 2'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedTriangleSet>"));
    const v1::TriangleMesh& mesh = loaded.scene.nodes(0).shape().mesh();
    return blob_values<float>(mesh.positions(), loaded.blobs);
  };
  EXPECT_EQ(triangles("true"), (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}));
  EXPECT_EQ(triangles("false"), (std::vector<float>{0, 0, 0, 0, 1, 0, 1, 0, 0}));
}

TEST(X3d, FollowsTheIndexRulesOfColours) {
  const auto colors = [](const std::string& fields) {
    const LoadedScene loaded = read_x3d_scene(shape(
        "<IndexedFaceSet coordIndex='0 1 2 -1 0 2 3' " + fields +
        "><Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0'/><Color color='1 0 0, 0 1 0, 0 0 1, 1 1 1'/>"
        "</IndexedFaceSet>"));
    const v1::TriangleMesh& mesh = loaded.scene.nodes(0).shape().mesh();
    EXPECT_TRUE(loaded.scene.materials(0).classic().vertex_color_replaces_diffuse());
    const auto values = blob_values<float>(mesh.colors(), loaded.blobs);
    const auto index = blob_values<uint32_t>(mesh.triangles(), loaded.blobs);
    std::string text;  // one letter a corner
    for (const uint32_t i : index) {
      const float* c = &values[4 * i];
      text += c[0] + c[1] + c[2] > 1 ? 'w' : c[0] > 0 ? 'r' : c[1] > 0 ? 'g' : 'b';
    }
    return text;
  };
  EXPECT_EQ(colors(""), "rgbrbw");
  EXPECT_EQ(colors("colorIndex='3 2 1 -1 0 0 0'"), "wbgrrr");
  EXPECT_EQ(colors("colorPerVertex='false'"), "rrrggg");
  EXPECT_EQ(colors("colorPerVertex='false' colorIndex='2 3'"), "bbbwww");
}

TEST(X3d, CutsStripsFansAndQuads) {
  const std::string points = "<Coordinate point='0 0 0 1 0 0 0 1 0 1 1 0'/>";
  const auto count = [&](const std::string& type, const std::string& fields) {
    const LoadedScene loaded =
        read_x3d_scene(shape("<" + type + " " + fields + ">" + points + "</" + type + ">"));
    return loaded.scene.nodes(0).shape().mesh().triangles().size() / 12;
  };
  EXPECT_EQ(count("TriangleSet", ""), 1u);
  EXPECT_EQ(count("TriangleStripSet", "stripCount='4'"), 2u);
  EXPECT_EQ(count("TriangleFanSet", "fanCount='4'"), 2u);
  EXPECT_EQ(count("IndexedTriangleStripSet", "index='0 1 2 3 -1 0 1 2'"), 3u);
  EXPECT_EQ(count("IndexedTriangleFanSet", "index='0 1 3 2'"), 2u);
  EXPECT_EQ(count("QuadSet", ""), 2u);
  EXPECT_EQ(count("IndexedQuadSet", "index='0 1 3 2 0'"), 2u);
}

TEST(X3d, ToleratesCommonSlipsAndSaysSo) {
  const LoadedScene loaded = read_x3d_scene(
      "<NavigationInfo headlight='FALSE'/><Spere/><TimeSensor/><Script/><TimeSensor/>"
      "<Transform tranlation='1 0 0'/>" +
      shape("<Sphere/>", "<Material transparency='2'/>"));
  EXPECT_FALSE(loaded.scene.cameras(0).has_headlight());
  const std::string all = testing::PrintToString(loaded.warnings);
  EXPECT_NE(all.find("unknown node 'Spere' is left out; did you mean 'Sphere'?"), all.npos) << all;
  EXPECT_NE(all.find("ignored: 1 Script, 2 TimeSensor"), all.npos) << all;
  EXPECT_NE(all.find("unknown field 'tranlation' of Transform"), all.npos) << all;
  EXPECT_NE(all.find("headlight='FALSE' is read as false"), all.npos) << all;
  EXPECT_NE(all.find("transparency of Material: '2'; expected 0 to 1; 1 is taken"), all.npos)
      << all;
}

TEST(X3d, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(x3d_error("<Group>\n").substr(0, 34), "t.x3d:3:3: not well-formed XML: St");
  EXPECT_EQ(error_of([] { parse_x3d("<html/>", "t.x3d", {}); }),
            "t.x3d:1:2: element 'html'; expected 'X3D'");
  EXPECT_EQ(error_of([] { parse_x3d("<X3D/>", "t.x3d", {}); }),
            "t.x3d:1:2: no Scene element; expected one inside X3D");
}

TEST(X3d, OneOddValueDoesNotCostTheFile) {
  const LoadedScene loaded = read_x3d_scene(
      "<Shape>\n<Sphere radius='-1'/></Shape>\n<Viewpoint fieldOfView='3.2'/>\n"
      "<Group visible='maybe'/>\n<SpotLight direction='0 0 0' cutOffAngle='3.2'/>\n"
      "<SpotLight cutOffAngle='0'/><SpotLight cutOffAngle='3.1416'/>\n" +
      shape("<Disk2D innerRadius='-1'/>") + shape("<Box size='0 1 1'/>"));
  EXPECT_EQ(
      loaded.warnings,
      (std::vector<std::string>{
          "t.x3d:3:17: radius of Sphere: '-1'; expected a length above 0; the shape is left out",
          "t.x3d:4:25: fieldOfView of Viewpoint: '3.2'; expected an angle between 0 and pi; pi / 4 "
          "is taken",
          "t.x3d:5:17: visible of Group: 'maybe'; expected true or false; true is taken",
          "t.x3d:6:23: direction of SpotLight: '0 0 0'; expected a direction; 0 0 -1 is taken",
          "t.x3d:6:43: cutOffAngle of SpotLight: '3.2'; expected an angle above 0, up to pi; "
          "3.14159 is taken",
          "t.x3d:7:25: cutOffAngle of SpotLight: '0'; expected an angle above 0, up to pi; the "
          "light is left "
          "out",
          "t.x3d:8:65: innerRadius of Disk2D: '-1'; expected 0 or more, and less than outerRadius; "
          "0 is "
          "taken",
          "t.x3d:9:55: size of Box: '0 1 1'; expected lengths above 0; the shape is left out"}));
  EXPECT_EQ(loaded.repairs.size(), loaded.warnings.size());
}

TEST(X3d, OnePartThatCannotBeReadDoesNotCostTheFile) {
  struct Case {
    std::string part, warning;
  };
  const std::vector<Case> cases{
      {"<Shape><Sphere radius='nan'/></Shape>",
       "2:24: radius of Sphere: 'nan'; expected a finite number; the field is left out"},
      {"<Shape><Sphere radius='1,5'/></Shape>",
       "2:24: radius of Sphere: 2 numbers; expected 1; the first one is taken"},
      {"<Transform translation='0 -1.#IND 0'/>",
       "2:27: translation of Transform: '-1.#IND'; expected a number; the field is left out"},
      {"<Transform translation='1 2'/>",
       "2:25: translation of Transform: 2 numbers; expected 3; the field is left out"},
      {"<Viewpoint fieldOfView='inf'/>",
       "2:25: fieldOfView of Viewpoint: 'inf'; expected a finite number; the field is left out"},
      {"<Switch whichChoice='x'/>",
       "2:22: whichChoice of Switch: 'x'; expected a 32-bit integer; the field is left out"},
      {"<Switch whichChoice='0 1'/>",
       "2:22: whichChoice of Switch: 2 numbers; expected 1; the first one is taken"},
      {"<Group DEF='Globe'/><Group USE='Glob'/>",
       "2:33: USE of 'Glob', which is not defined; did you mean 'Globe'?; expected the DEF name of "
       "a node before it; it is left out"},
      {"<Group USE='A'/><Group USE='B'/>",
       "2:13: USE of 'A', which is not defined; expected the DEF name of a node before it; it is "
       "left out (2 times)"},
      {"<Group DEF='G'><Group><Group USE='G'/></Group></Group>",
       "2:35: USE of 'G' inside itself; expected a graph without cycles; it is left out"},
      {"<Group DEF='G'/><Transform USE='G'/>",
       "2:33: Transform with USE of 'G', which is a Group; expected the same type; the node of "
       "that name is taken"},
      {"<Background skyColor='0 0 1 1'/>",
       "2:23: skyColor of Background: 4 numbers; expected a multiple of 3; the last ones are "
       "left out"},
  };
  for (const Case& c : cases) {
    const LoadedScene loaded = read_x3d_scene(c.part + shape("<Box/>"));
    EXPECT_TRUE(loaded.scene.nodes(loaded.scene.nodes_size() - 1).shape().has_box()) << c.part;
    EXPECT_EQ(loaded.warnings, std::vector<std::string>{"t.x3d:" + c.warning}) << c.part;
    EXPECT_EQ(loaded.repairs.size(), 1u) << c.part;
  }
}

TEST(X3d, BoundsNestingAndNeverFollowsEntities) {
  std::string deep;
  for (int i = 0; i < 100; ++i) deep += "<Group>";
  for (int i = 0; i < 100; ++i) deep += "</Group>";
  EXPECT_NE(x3d_error(deep).find("nodes nested too deep; expected at most 80 levels"),
            std::string::npos);
  // Twice the group before it, forty times: 2^40 spheres that are stored forty times.
  std::string laughs = "<Group DEF='G0'>" + shape("<Sphere/>") + "</Group>";
  for (int i = 1; i <= 40; ++i) {
    const std::string last = "<Group USE='G" + std::to_string(i - 1) + "'/>";
    laughs += "<Group DEF='G" + std::to_string(i) + "'>" + last + last + "</Group>";
  }
  EXPECT_LT(read_x3d_scene(laughs).scene.ByteSizeLong(), 10000u);
  const std::string entity =
      "<!DOCTYPE X3D [<!ENTITY x SYSTEM 'file:///etc/hostname'>]><X3D><Scene>"
      "<Group DEF='&x;'/></Scene></X3D>";
  EXPECT_EQ(parse_x3d(entity, "t.x3d", {}).scene.nodes(0).name(), "&x;");
}

TEST(X3d, TellsOfEachPartThatIsWrong) {
  const std::string text = "<X3D><Scene>\n<Inline url='a.x3d'/>\n<Group>\n<Inline url='b.x3d'/>\n" +
                           shape("<Box/>") + "\n<Inline url='c.x3d'/></Group>\n</Scene></X3D>";
  ReadOptions strict;
  strict.x3d_strict = true;
  const auto read = [&] { parse_x3d(text, "t.x3d", strict); };
  std::vector<int> lines;
  try {
    read();
  } catch (const Error& error) {
    for (const Diagnostic& each : error.diagnostics()) lines.push_back(each.place.line);
  }
  EXPECT_EQ(lines, (std::vector<int>{2, 4, 7})) << error_of(read);
  std::string many;
  for (int i = 0; i < 30; ++i) many += "<Inline url='a.x3d'/>";
  EXPECT_NE(error_of([&] {
              parse_x3d("<X3D><Scene>" + many + "</Scene></X3D>", "t.x3d", strict);
            }).find("20 errors; the rest"),
            std::string::npos);
}

}  // namespace
}  // namespace tessera
