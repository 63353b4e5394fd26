// The three encodings, prototypes, and files that name other files.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/file.h"
#include "proto/wire/scene_codec.h"
#include "scenes/formats/read_scene.h"
#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::string error(const std::string& text) {
  return error_of([&] { parse_x3d(text, "t.wrl", {}); });
}

/// Without its metadata, so that files of different names compare.
std::string description(LoadedScene loaded) {
  loaded.scene.clear_metadata();
  return loaded.scene.DebugString();
}

constexpr const char* kXml =
    "<X3D version='3.3'><Scene><Viewpoint DEF='V' description='a \"view\"' position='1 2 3'/>"
    "<Transform DEF='T' translation='1 0 0'><Shape DEF='S'><Appearance><Material DEF='M' "
    "diffuseColor='1 0 0'/></Appearance><IndexedFaceSet solid='false' coordIndex='0 1 2 -1 2 1 3'>"
    "<Coordinate point='0 0 0 1 0 0 0 1 0 1 1 0'/></IndexedFaceSet></Shape></Transform>"
    "<Group><Shape USE='S'/></Group></Scene></X3D>";
constexpr const char* kClassic =
    "#X3D V3.3 utf8\nPROFILE Immersive COMPONENT Core:2 META \"a\" \"b\"\n"
    "DEF V Viewpoint { description \"a \\\"view\\\"\" position 1 2,3 } # a comment with \" in it\n"
    "DEF T Transform {\n  translation 1 0 0\n  children [\n    DEF S Shape {\n      appearance "
    "Appearance { material DEF M Material { diffuseColor 1 0 0 } }\n      geometry IndexedFaceSet "
    "{ solid FALSE coordIndex [ 0 1 2 -1, # first\n 2 1 3, ] coord Coordinate { point [ 0 0 0, 1 0 "
    "0, 0 1 0, 1 1 0 ] } }\n    }\n  ]\n}\nGroup { children USE S }\n";

/// zlib is the tests' other way round: made with `gzip -n`.
std::string gzipped_empty_scene() {
  const unsigned char bytes[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                                 0x03, 0x53, 0x8e, 0x30, 0x76, 0x51, 0x08, 0x33, 0xd6,
                                 0x33, 0x56, 0x28, 0x2d, 0x49, 0xb3, 0xe0, 0x02, 0x00,
                                 0x94, 0x7a, 0x61, 0xea, 0x0f, 0x00, 0x00, 0x00};
  return {reinterpret_cast<const char*>(bytes), sizeof bytes};
}

TEST(X3dEncodings, SayTheSame) {
  const std::string expected = description(parse_x3d(kXml, "a.x3d", {}));
  EXPECT_EQ(description(parse_x3d(kClassic, "a.x3dv", {})), expected);
  std::string vrml = kClassic;
  vrml.replace(0, 14, "#VRML V2.0 utf8");
  vrml.erase(vrml.find("PROFILE"), vrml.find('\n', 20) - vrml.find("PROFILE"));
  EXPECT_EQ(description(parse_x3d(vrml, "a.wrl", {})), expected);
}

TEST(X3dEncodings, WarningsSayWhereAsErrorsDo) {
  // What is wrong stands where it is first written, however often it is.
  const std::vector<std::string> xml =
      parse_x3d(
          "<X3D version='7'><Scene>\n<Foo/>\n <Foo/><Shape bar='1'><Appearance>\n"
          "<Material transparency='2'/></Appearance><Sphere/></Shape>\n"
          "<TimeSensor/></Scene></X3D>",
          "t.x3d", {})
          .warnings;
  EXPECT_EQ(xml,
            (std::vector<std::string>{
                "t.x3d:2:2: unknown node 'Foo' is left out; did you mean 'Fog'? (2 times)",
                "t.x3d:3:20: unknown field 'bar' of Shape is left out",
                "t.x3d:4:25: transparency of Material outside 0 to 1 is clamped",
                "t.x3d: ignored: 1 TimeSensor", "t.x3d:1:15: unknown version '7' is read as 3.3"}));
  const std::string body =
      "\nShape { geometry IndexedFaceSet {\n coordIndex [ 0 1 0 -1 0 1 2 ]\n"
      " coord Coordinate { point [ 0 0 0 1 0 0 0 1 0 ] } } }\n"
      "Background { skyColor [ 0 0 0 ]\n skyAngle 1 }\n"
      "Transform {\n  rotation 0 0 0 1 }\nPointLight { color 2 0 0 radius 1 radius 2 }";
  for (const std::string header : {"#X3D V3.3 utf8", "#VRML V2.0 utf8"}) {
    const std::vector<std::string> classic = parse_x3d(header + body, "t.wrl", {}).warnings;
    EXPECT_EQ(classic,
              (std::vector<std::string>{
                  "t.wrl:3:15: faces with fewer than 3 different points are left out",
                  "t.wrl:6:11: a Background needs one angle fewer than colours; what is left over "
                  "is left out",
                  "t.wrl:8:12: rotation of Transform about no axis is left out",
                  "t.wrl:9:20: color of PointLight outside 0 to 1 is clamped",
                  "t.wrl:9:42: radius is given twice in PointLight; the first one holds"}))
        << header;
  }
}

TEST(X3dEncodings, AFieldThatTheParentLacksIsThatOfTheNodesType) {
  const LoadedScene loaded = parse_x3d(
      "<X3D version='3.3'><Scene><Shape><Appearance containerField='children'/>\n"
      "<Sphere containerField='children'/></Shape><Switch whichChoice='0'>"
      "<Group containerField='choice'/></Switch><Collision><Shape containerField='proxy'><Box/>"
      "</Shape></Collision></Scene></X3D>",
      "t.x3d", {});
  EXPECT_TRUE(loaded.scene.nodes(0).shape().has_sphere());
  EXPECT_EQ(loaded.scene.nodes(1).children_size(), 1);
  EXPECT_EQ(loaded.scene.nodes(2).children_size(), 0);
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{
                "t.x3d:1:62: Shape has no field 'children' for Appearance; 'appearance' is taken",
                "t.x3d:2:25: Shape has no field 'children' for Sphere; 'geometry' is taken"}));
}

TEST(X3dEncodings, NamesAndUsesWithoutANameAreNone) {
  const LoadedScene loaded =
      parse_x3d("<X3D version='3.3'><Scene><Shape DEF='' USE=''><Sphere/></Shape></Scene></X3D>",
                "t.x3d", {});
  EXPECT_TRUE(loaded.scene.nodes(0).shape().has_sphere());
}

TEST(X3dEncodings, GroupsMayStandAsDeepAsFilesMay) {
  const auto nested = [](int levels) {
    std::string text = "#X3D V3.3 utf8\n";
    for (int i = 0; i < levels; ++i) text += "Transform { translation 1 0 0 children [ ";
    text += "Shape { geometry Sphere { } } ";
    for (int i = 0; i < levels; ++i) text += "] } ";
    return text;
  };
  for (const int levels : {31, 32, 62, 63, 64, 77}) {
    const LoadedScene loaded = parse_x3d(nested(levels), "t.x3dv", {});
    EXPECT_NO_THROW(check_scene(loaded.scene, "t.x3dv")) << levels;
    int depth = 0;
    const v1::Node* node = &loaded.scene.nodes(0);
    while (!node->has_shape()) {
      depth += node->has_transform();
      if (node->children_size() == 1) {
        node = &node->children(0);
        continue;
      }
      const auto& objects = loaded.scene.objects();
      const auto object = std::find_if(
          objects.begin(), objects.end(),
          [&](const v1::Object& candidate) { return candidate.name() == node->instance_of(); });
      ASSERT_NE(object, objects.end()) << levels;
      node = &object->nodes(0);
    }
    EXPECT_EQ(depth, levels);
  }
  EXPECT_EQ(error(nested(100)).substr(0, 8), "t.wrl:2:");
}

TEST(X3dEncodings, GroupsOfPrototypesEndWithAPlace) {
  std::string text = "#X3D V3.3 utf8\nPROTO P0 [ ] { Group { children Shape { } } }";
  for (int i = 1; i < 190; ++i) {
    const std::string before = std::to_string(i - 1);
    text += "\nPROTO P" + std::to_string(i) + " [ ] { Group { children P" + before + " { } } }";
  }
  EXPECT_EQ(error(text + "P189 { }").substr(0, 37), "t.wrl:16:17: groups nested too deep; ");
}

TEST(X3dEncodings, AreToldApartByTheirFirstBytes) {
  EXPECT_EQ(error("#VRML V1.0 ascii\nSeparator { }"),
            "t.wrl:1:1: VRML 1.0, a different language; expected VRML 2.0 (VRML97) or X3D");
  EXPECT_EQ(error("Shape { }").substr(0, 50), "t.wrl:1:1: a file that does not say what it is; ex");
  EXPECT_EQ(error("\x1f\x8bxx"), "t.wrl: broken gzip data; expected a whole gzipped file");
  const std::string gzip = gzipped_empty_scene();
  EXPECT_EQ(parse_x3d(gzip, "a.x3dz", {}).scene.cameras_size(), 1);
  for (size_t size = 2; size < gzip.size(); ++size)
    EXPECT_EQ(error(gzip.substr(0, size)),
              "t.wrl: broken gzip data; expected a whole gzipped file");
}

TEST(X3dEncodings, ReadsWhatVrml97NamesOtherwise) {
  const auto loaded = parse_classic(
      "Switch { whichChoice 1 choice [ Shape { geometry Box { } } Shape { geometry Sphere { } } ] }"
      "LOD { range [ 1 2 ] level [ Shape { geometry Cone { } } Shape { geometry Box { } } ] }",
      "VRML");
  EXPECT_TRUE(loaded.scene.nodes(0).children(0).shape().has_sphere());
  EXPECT_TRUE(loaded.scene.nodes(1).children(0).shape().has_cone());
}

TEST(X3dEncodings, SayWhereTheClassicOneIsWrong) {
  const auto of = [](const std::string& scene) { return error("#X3D V3.3 utf8\n" + scene); };
  EXPECT_EQ(of("Shape {"), "t.wrl:2:8: the end of the file; expected a field, or '}'");
  EXPECT_EQ(of("Shape }"), "t.wrl:2:7: '}'; expected '{'");
  EXPECT_EQ(of("Shape { geometry 7 }").substr(0, 11), "no error");
  EXPECT_EQ(of("\n  Sphere { radius \"x }"),
            "t.wrl:3:19: a string without an end; expected a "
            "closing quote");
  EXPECT_EQ(of("Transform { children [ Shape { } } ]").substr(0, 12), "t.wrl:2:34: ");
  EXPECT_EQ(of("Shape { geometry Sphere { radius 1x } }"), "t.wrl:2:34: '1x'; expected a number");
  EXPECT_EQ(of("DEF A Group { } USE B"),
            "t.wrl:2:21: USE of 'B', which is not defined; expected the DEF name of a node before "
            "it; did you mean 'A'?");
  EXPECT_EQ(of("DEF G Group { children USE G }"),
            "t.wrl:2:28: USE of 'G' inside itself; expected a graph without cycles");
  EXPECT_EQ(of("UNIT length furlong -1"),
            "t.wrl:2:21: a length unit of -1; expected a factor "
            "above 0");
  std::string deep;
  for (int i = 0; i < 100; ++i) deep += "Group { children ";
  EXPECT_NE(of(deep).find("nodes nested too deep; expected at most 80 levels"), std::string::npos);
}

TEST(X3dEncodings, ShowsHumanoidsAsTheyStand) {
  const auto loaded = parse_classic(
      "HAnimHumanoid { skeleton DEF J HAnimJoint { translation 1 0 0 center 5 5 5 rotation 0 1 0 1 "
      "children HAnimSegment { children Shape { geometry Box { } } } } joints USE J }");
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  ASSERT_EQ(loaded.scene.nodes(0).children_size(), 1);
  ASSERT_EQ(loaded.scene.objects_size(), 1);
  const v1::Node& joint = loaded.scene.objects(0).nodes(0);
  EXPECT_EQ(joint.transform().steps_size(), 4);
  EXPECT_TRUE(joint.children(0).children(0).shape().has_box());
}

TEST(X3dEncodings, SaysWhatItTakesForZero) {
  const auto warnings =
      parse_classic("PointLight { intensity -1 attenuation 0 -1 1 radius -3 }").warnings;
  ASSERT_EQ(warnings.size(), 3u);
  EXPECT_EQ(warnings[0], "t.x3dv:2:24: intensity of PointLight below 0 is read as 0");
}

TEST(X3dEncodings, SuggestsFieldNames) {
  const auto warnings =
      parse_classic("Shape { apearance Appearance { } geometry Sphere { radios 3 } }").warnings;
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(
      warnings[0],
      "t.x3dv:2:19: unknown field 'apearance' of Shape is left out; did you mean 'appearance'?");
  EXPECT_EQ(warnings[1],
            "t.x3dv:2:59: unknown field 'radios' of Sphere is left out; did you mean 'radius'?");
}

TEST(X3dEncodings, ListsWhatIsIgnoredOnceWithCounts) {
  const auto warnings =
      parse_classic(
          "DEF T TimeSensor { } DEF I PositionInterpolator { key [ 0 1 ] } "
          "DEF G Transform { } DEF S Script { eventIn SFTime x field SFNode n USE "
          "G url \"javascript: {}\" } "
          "ROUTE T.fraction_changed TO I.set_fraction ROUTE I.value_changed TO "
          "G.set_translation TimeSensor { }")
          .warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "t.x3dv: ignored: 1 PositionInterpolator, 2 ROUTE, 1 Script, 2 TimeSensor");
}

TEST(X3dEncodings, InstancesOfPrototypesInOtherFilesAreIgnoredToo) {
  const auto warnings =
      parse_classic(
          "EXTERNPROTO Foo [ field SFColor c ] \"protos.wrl#Foo\" Foo { c 1 0 0 } "
          "DEF F Foo { } Transform { children USE F }")
          .warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], "t.x3dv: ignored: 1 ExternProtoDeclare, 2 ProtoInstance");
}

constexpr const char* kBallProto =
    "PROTO Ball [ inputOutput SFColor color 1 0 0 initializeOnly SFFloat size 1 inputOutput MFNode "
    "extra [ ] inputOnly SFTime now ] { Transform { children [ Shape { appearance Appearance { "
    "material Material { diffuseColor IS color } } geometry Sphere { radius IS size } } Group { "
    "children IS extra } ] } TimeSensor { startTime IS now } } ";

TEST(X3dPrototypes, TakeTheInstancesValuesElseTheInterfaces) {
  const auto loaded = parse_classic(std::string(kBallProto) +
                                    "Ball { } DEF B Ball { color 0 0 1 size 3 extra [ Shape { "
                                    "geometry Box { } } Shape { geometry Cone { } } ] }");
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  ASSERT_EQ(loaded.scene.nodes_size(), 2);
  const v1::Node& plain = loaded.scene.nodes(0);
  const v1::Node& given = loaded.scene.nodes(1);
  EXPECT_EQ(plain.children(0).shape().sphere().radius(), 1);
  EXPECT_EQ(plain.children(1).children_size(), 0);
  EXPECT_EQ(given.name(), "B");
  EXPECT_EQ(given.children(0).shape().sphere().radius(), 3);
  EXPECT_EQ(given.children(1).children_size(), 2);
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().r(), 1);
  EXPECT_EQ(loaded.scene.materials(1).classic().diffuse().value().b(), 1);
}

TEST(X3dPrototypes, PassValuesOnThroughOthers) {
  const auto loaded = parse_classic(std::string(kBallProto) +
                                    "PROTO Two [ inputOutput SFColor tint 0 1 0 ] { Group { "
                                    "children [ Ball { color IS tint } Ball { size 2 } ] } } "
                                    "Two { } Two { tint 0 0 .5 }");
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().g(), 1);
  EXPECT_EQ(loaded.scene.materials(1).classic().diffuse().value().r(), 1);
  EXPECT_EQ(loaded.scene.materials(2).classic().diffuse().value().b(), .5);
}

TEST(X3dPrototypes, AreTheSameInXml) {
  const auto loaded = parse_x3d(
      "<X3D version='3.3'><Scene><ProtoDeclare name='Ball'><ProtoInterface><field name='size' "
      "accessType='inputOutput' type='SFFloat' value='1'/><field name='look' type='SFNode' "
      "accessType='inputOutput'><Appearance/></field></ProtoInterface><ProtoBody><Shape><IS>"
      "<connect nodeField='appearance' protoField='look'/></IS><Sphere><IS><connect "
      "nodeField='radius' protoField='size'/></IS></Sphere></Shape></ProtoBody></ProtoDeclare>"
      "<ProtoInstance name='Ball' DEF='A'><fieldValue name='size' value='4'/></ProtoInstance>"
      "<Group><ProtoInstance name='Ball'><fieldValue name='look'><Appearance><Material/>"
      "</Appearance></fieldValue></ProtoInstance><ProtoInstance USE='A'/></Group></Scene></X3D>",
      "t.x3d", {});
  ASSERT_EQ(loaded.scene.objects_size(), 1);
  EXPECT_EQ(loaded.scene.objects(0).nodes(0).shape().sphere().radius(), 4);
  EXPECT_EQ(loaded.scene.nodes(1).children(0).shape().sphere().radius(), 1);
  EXPECT_TRUE(loaded.scene.materials(1).has_classic());
  EXPECT_EQ(loaded.scene.nodes(1).children(1).instance_of(), "A");
}

TEST(X3dPrototypes, EndWhereTheyWouldGrowWithoutEnd) {
  std::string text = "#X3D V3.3 utf8\nPROTO P0 [ ] { Group { } } ";
  for (int i = 1; i < 30; ++i) {
    const std::string inner = "P" + std::to_string(i - 1) + " { } ";
    text += "PROTO P" + std::to_string(i) + " [ ] { Group { children [ " + inner + inner + inner +
            inner + "] } } ";
  }
  EXPECT_NE(error(text).find("prototypes that become too many nodes; expected at most 200000"),
            std::string::npos);
}

TEST(X3dPrototypes, EndWhereTheyAreNestedTooDeep) {
  const std::string limit = "nodes nested too deep; expected at most 80 levels";
  std::string instances, declarations, classic = "#X3D V3.3 utf8\nPROTO P [ ] { Group { } } ";
  for (int i = 0; i < 50000; ++i) {
    instances += "<ProtoInstance name='P'><fieldValue name='x'>";
    declarations += "<ProtoDeclare name='P'><ProtoInterface><field name='x'>";
    classic += "PROTO Q [ ] { ";
  }
  const std::string xml =
      "<X3D><Scene><ProtoDeclare name='P'><ProtoBody><Group/></ProtoBody>"
      "</ProtoDeclare>";
  const auto close = [](const std::string& open) {
    std::string out;
    for (size_t at = open.size(); (at = open.rfind('<', at - 1)) != std::string::npos;) {
      out += "</" + open.substr(at + 1, open.find_first_of(" >", at) - at - 1) + ">";
      if (at == 0) break;
    }
    return out;
  };
  for (const std::string& open : {instances, declarations})
    EXPECT_NE(error(xml + open + close(open) + "</Scene></X3D>").find(limit), std::string::npos);
  EXPECT_NE(error(classic).find(limit), std::string::npos);
}

TEST(X3dEncodings, SaysWhatIsGivenTwice) {
  const auto loaded =
      parse_classic("Shape { geometry Box { } geometry Sphere { radius 1 radius 2 } }");
  EXPECT_TRUE(loaded.scene.nodes(0).shape().has_sphere());
  ASSERT_EQ(loaded.warnings.size(), 2u);
  EXPECT_EQ(loaded.warnings[0],
            "t.x3dv:2:35: geometry of Shape is given twice; the last one holds");
  EXPECT_EQ(loaded.warnings[1],
            "t.x3dv:2:60: radius is given twice in Sphere; the first one holds");
}

/// A folder with a scene and what it names, and a file beside the folder that it must not see.
class X3dFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    outside_ =
        fs::temp_directory_path() / ("tessera_x3d_" + std::to_string(::getpid()) + "_" +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
    folder_ = outside_ / "scene";
    fs::create_directories(folder_ / "parts");
  }
  void TearDown() override { fs::remove_all(outside_); }

  std::string write(const std::string& name, const std::string& text) const {
    const fs::path path = folder_ / name;
    std::ofstream(path) << "#X3D V3.3 utf8\n" << text;
    return path.string();
  }
  std::string error_reading(const std::string& path) const {
    const std::string all = error_of([&] { read_x3d(path, {}); });
    return all.substr(all.rfind('/') + 1);
  }

  fs::path outside_, folder_;
};

TEST_F(X3dFilesTest, InlinesAreObjectsWithNamesOfTheirOwn) {
  write("parts/inner.x3dv",
        "DEF Same Viewpoint { position 0 0 3 } Background { skyColor 0 1 0 } "
        "NavigationInfo { headlight FALSE } DirectionalLight { } "
        "Shape { geometry Sphere { } } Inline { url \"innermost.x3dv\" }");
  write("parts/innermost.x3dv", "UNIT length inch 0.0254 Shape { geometry Box { } }");
  const std::string main = write(
      "main.x3dv",
      "Transform { translation 1 0 0 children [ DEF Same Inline { url [ \"none.x3d\" "
      "\"parts/inner.x3dv\" ] } ] } Group { children Inline { url \"parts/inner.x3dv#Same\" } }");
  const LoadedScene loaded = read_x3d(main, {});
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  ASSERT_EQ(loaded.scene.objects_size(), 2);
  EXPECT_EQ(loaded.scene.objects(0).name(), "innermost");
  const v1::Node& scaled = loaded.scene.objects(0).nodes(0);
  EXPECT_EQ(scaled.transform().steps(0).scale().x(), .0254);
  EXPECT_EQ(loaded.scene.objects(1).name(), "inner");
  EXPECT_EQ(loaded.scene.nodes(0).children(0).instance_of(), "inner");
  EXPECT_EQ(loaded.scene.nodes(1).children(0).instance_of(), "inner");
  // What it can bind is bound, since the first file binds nothing.
  EXPECT_EQ(loaded.scene.background().solid().g(), 1);
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  EXPECT_FALSE(loaded.scene.cameras(0).has_headlight());
  EXPECT_EQ(loaded.scene.cameras(0).world_from_camera().steps(0).translate().x(), 1);
}

TEST_F(X3dFilesTest, WhatCannotBeInlinedIsLeftOutWithAReason) {
  std::ofstream(outside_ / "secret.x3dv") << "#X3D V3.3 utf8\nShape { geometry Box { } }";
  fs::create_symlink(outside_ / "secret.x3dv", folder_ / "link.x3dv");
  const std::string main = write(
      "main.x3dv",
      "Inline { url \"../secret.x3dv\" }\nInline { url \"link.x3dv\" }\nInline { url "
      "\"https://example.org/a.x3d\" }\nInline { url \"" +
          (outside_ / "secret.x3dv").string() +
          "\" }\nInline { url \"no.x3d\" }\nInline { load FALSE url \"no.x3d\" }\nInline { }");
  const LoadedScene loaded = read_x3d(main, {});
  EXPECT_EQ(loaded.scene.objects_size(), 0);
  std::string all;
  for (const std::string& warning : loaded.warnings)
    all += warning.substr(warning.find("main.x3dv:")) + "\n";
  const std::string inside = " is left out: it is not inside the scene's folder\n";
  EXPECT_EQ(all,
            "main.x3dv:2:1: Inline of '../secret.x3dv'" + inside +
                "main.x3dv:3:1: Inline of 'link.x3dv'" + inside +
                "main.x3dv:4:1: Inline of 'https://example.org/a.x3d' is left out: only files are "
                "read, and nothing from the network\nmain.x3dv:5:1: Inline of '" +
                (outside_ / "secret.x3dv").string() + "'" + inside +
                "main.x3dv:6:1: Inline of 'no.x3d' is left out: there is no such file\n");
}

TEST_F(X3dFilesTest, WhatCannotBeReadIsLeftOutAsWhatIsMissing) {
  std::ofstream(folder_ / "old.wrl") << "#VRML V1.0 ascii\nCube { }";
  std::ofstream(folder_ / "broken.x3dv") << "#X3D V3.3 utf8\nShape { geometry Box {";
  const std::string main = write("main.x3dv",
                                 "Inline { url \"old.wrl\" }\nInline { url \"broken.x3dv\" }\n"
                                 "Shape { geometry Sphere { } }");
  const LoadedScene loaded = read_x3d(main, {});
  ASSERT_EQ(loaded.warnings.size(), 2u);
  const auto tells = [&](size_t warning, const char* what) {
    return loaded.warnings[warning].find(what) != std::string::npos;
  };
  EXPECT_TRUE(tells(0, "main.x3dv:2:1: Inline of 'old.wrl' is left out: ")) << loaded.warnings[0];
  EXPECT_TRUE(tells(0, "old.wrl:1:1: VRML 1.0")) << loaded.warnings[0];
  EXPECT_TRUE(tells(1, "broken.x3dv:")) << loaded.warnings[1];
  EXPECT_EQ(loaded.scene.objects_size(), 0);
  ReadOptions strict;
  strict.x3d_strict = true;
  EXPECT_THROW(read_x3d(main, strict), Error);
}

TEST_F(X3dFilesTest, FilesAreNoPartOfThemselves) {
  const std::string self = write("self.x3dv", "Inline { url \"self.x3dv\" }");
  EXPECT_EQ(error_reading(self),
            "self.x3dv:2:1: Inline of 'self.x3dv', of which it is a part; expected files that are "
            "not a part of themselves");
  write("b.x3dv", "Inline { url \"a.x3dv\" }");
  const std::string a = write("a.x3dv", "Inline { url \"b.x3dv\" }");
  EXPECT_EQ(error_reading(a).substr(0, 26), "b.x3dv:2:1: Inline of 'a.x");
  for (int i = 0; i < 20; ++i)
    write("d" + std::to_string(i) + ".x3dv",
          "Inline { url \"d" + std::to_string(i + 1) + ".x3dv\" }");
  EXPECT_NE(error_reading((folder_ / "d0.x3dv").string()).find("too many Inlines"),
            std::string::npos);
}

/// In time that grows with the square of a number these would outlast the test's time limit.
TEST(X3dEncodings, WhatIsManyTakesTimeInItsNumber) {
  constexpr int kShapes = 150'000, kFields = 200'000, kInstances = 190'000;
  std::string same_names = "#VRML V2.0 utf8\n";
  for (int i = 0; i < kShapes; ++i) same_names += "DEF a Shape{geometry Box{}} USE a\n";
  const LoadedScene shapes = parse_x3d(same_names, "t.wrl", {});
  ASSERT_EQ(shapes.scene.objects_size(), kShapes);
  EXPECT_EQ(shapes.scene.objects(kShapes - 1).name(), "a_" + std::to_string(kShapes));
  std::string prototype = "#VRML V2.0 utf8\nPROTO p [ ";
  for (int i = 0; i < kFields; ++i) prototype += "field SFFloat f" + std::to_string(i) + " 0\n";
  prototype += "] { Transform { ";
  for (int i = 1; i <= 10; ++i) prototype += "bboxCenter IS f" + std::to_string(kFields - i) + "\n";
  prototype += "} }\n";
  for (int i = 0; i < kInstances; ++i) prototype += "p{}\n";
  EXPECT_EQ(parse_x3d(prototype, "t.wrl", {}).scene.nodes_size(), kInstances);
}

TEST(X3dEncodings, ListsAreNotReadAgainAndAgainForever) {
  std::string text =
      "#VRML V2.0 utf8\nShape { geometry PointSet { coord DEF c Coordinate { point [ ";
  for (int i = 0; i < 50'000; ++i) text += "0 1 2 ";
  text += "] } } }\n";
  for (int i = 0; i < 2'000; ++i) text += "Shape { geometry PointSet { coord USE c } }\n";
  EXPECT_NE(
      error(text).find("lists that are used too often; expected at most 256 MiB, and 16 times the "
                       "file, read in all"),
      std::string::npos);
}

/// All of a file is read, or nothing of it: what its first nodes put into the scene goes too.
TEST_F(X3dFilesTest, OfAFileThatIsWrongNothingIsLeft) {
  write("good.x3dv", "Shape { geometry Box { } }");
  write("broken.x3dv",
        "DEF V Viewpoint { } Background { } Fog { visibilityRange 9 } NavigationInfo { headlight "
        "FALSE } DEF S Shape { appearance Appearance { material Material { } texture ImageTexture "
        "{ url \"none.png\" } } geometry Box { } } USE S Inline { url \"good.x3dv\" }\n"
        "Shape { geometry Sphere { radius -1 } }");
  write("outer.x3dv", "Inline { url \"broken.x3dv\" } Inline { url \"good.x3dv\" }");
  const std::string urls = "Inline { url [ \"broken.x3dv\" \"outer.x3dv\" ] }";
  const LoadedScene loaded = read_x3d(write("main.x3dv", urls + urls), {});
  EXPECT_EQ(loaded.scene.textures_size(), 0);
  EXPECT_EQ(loaded.scene.materials_size(), 1) << "of good.x3dv";
  EXPECT_EQ(loaded.scene.background().kind_case(), v1::Background::KIND_NOT_SET);
  EXPECT_FALSE(loaded.scene.has_fog());
  ASSERT_EQ(loaded.scene.cameras_size(), 1);
  EXPECT_EQ(loaded.scene.cameras(0).name(), "default") << "none of the file's";
  EXPECT_TRUE(loaded.scene.cameras(0).has_headlight());
  ASSERT_EQ(loaded.scene.objects_size(), 2);
  EXPECT_EQ(loaded.scene.objects(1).name(), "outer");
  for (const v1::Node& node : loaded.scene.nodes()) EXPECT_EQ(node.instance_of(), "outer");
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(loaded.warnings[0].find("outer.x3dv:2:1: Inline of 'broken.x3dv' is left out: "),
            std::string::npos)
      << loaded.warnings[0];
  EXPECT_NE(loaded.warnings[0].find("broken.x3dv:3:34: radius -1 of Sphere; expected a length"),
            std::string::npos)
      << loaded.warnings[0];
}

TEST_F(X3dFilesTest, OtherFormatsBecomeObjectsToo) {
  std::ofstream(folder_ / "parts/card.obj") << "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n";
  const std::string main = write(
      "main.x3dv",
      "Transform { translation 3 0 0 children DEF I Inline { url \"parts/card.obj\" } } USE I");
  const LoadedScene loaded = read_scene(main);
  const std::string inlined = loaded.scene.objects(0).nodes(0).instance_of();
  EXPECT_EQ(loaded.scene.includes_size(), 0);
  size_t triangles = 0;
  for (const v1::Object& object : loaded.scene.objects())
    for (const v1::Node& node : object.nodes()) triangles += node.shape().has_mesh() ? 1 : 0;
  EXPECT_EQ(triangles, 1u);
  EXPECT_FALSE(inlined.empty());
  EXPECT_GT(render_loaded(loaded, 1, 1)[0], 0);
}

TEST_F(X3dFilesTest, MissingPicturesHaveAPlaceholder) {
  const std::string main =
      write("main.x3dv",
            "Shape { geometry Box { } appearance DEF A Appearance { texture ImageTexture { url "
            "\"none.png\" } } } Shape { geometry Sphere { } appearance USE A }");
  const LoadedScene loaded = read_x3d(main, {});
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_NE(
      loaded.warnings[0].find("main.x3dv:2:64: a placeholder stands for the picture 'none.png': "
                              "there is no such file"),
      std::string::npos);
  ASSERT_EQ(loaded.scene.textures_size(), 1);
  EXPECT_EQ(loaded.scene.textures(0).image().width(), 2u);
}

TEST_F(X3dFilesTest, StrictReadingTakesNothingForMissingFiles) {
  ReadOptions strict;
  strict.x3d_strict = true;
  for (const char* missing : {"Shape { appearance Appearance { texture ImageTexture { url "
                              "\"none.png\" } } geometry Box { } }",
                              "Inline { url \"none.png\" }"}) {
    const std::string main = write("main.x3dv", missing);
    EXPECT_NO_THROW(read_x3d(main, {}));
    try {
      read_x3d(main, strict);
      ADD_FAILURE() << missing;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("main.x3dv:2:"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("'none.png'"), std::string::npos) << error.what();
    }
  }
}

/// Decoders that take what begins with "good" for a white picture.
ReadOptions picky_decoders() {
  const auto decode = [](const std::string& text, const std::string& name) {
    if (!text.starts_with("good")) throw scene_error(SourcePlace{name}, "no picture", "one");
    return DecodedTexture{
        .width = 1, .height = 1, .channels = 1, .bits = 8, .texels = make_blob({std::byte{255}})};
  };
  ReadOptions options;
  options.decode_texture = [=](const std::string& path, bool) {
    return decode(read_input_file(path, 1000), path);
  };
  options.decode_texture_bytes = [=](std::string_view bytes, const std::string& name) {
    return decode(std::string(bytes), name);
  };
  return options;
}

TEST_F(X3dFilesTest, TheFirstPictureThatCanBeDecodedIsTaken) {
  std::ofstream(folder_ / "bad.png") << "bad";
  std::ofstream(folder_ / "good.png") << "good";
  const auto read = [&](const std::string& urls, bool strict = false) {
    ReadOptions options = picky_decoders();
    options.x3d_strict = strict;
    return read_scene(write("main.x3dv",
                            "Shape { geometry Box { } appearance Appearance { texture "
                            "ImageTexture { url [ " +
                                urls + " ] } } }"),
                      options);
  };
  const auto warning = [&](const LoadedScene& loaded) {
    return loaded.warnings.size() == 1
               ? loaded.warnings[0].substr(loaded.warnings[0].find("main.x3dv:"))
               : std::to_string(loaded.warnings.size()) + " warnings";
  };
  const LoadedScene second = read("\"bad.png\" \"good.png\"");
  EXPECT_EQ(second.scene.textures(0).image().file(), "good.png");
  EXPECT_EQ(second.scene.textures(0).image().width(), 1u);
  EXPECT_EQ(warning(second),
            "main.x3dv:2:58: the picture is 'good.png', not 'bad.png': no picture; expected one");
  const LoadedScene none = read("\"none.png\" \"bad.png\"");
  EXPECT_EQ(none.scene.textures(0).image().width(), 2u) << "the placeholder";
  EXPECT_EQ(
      warning(none),
      "main.x3dv:2:58: a placeholder stands for the picture 'none.png': there is no such file; "
      "'bad.png': no picture; expected one");
  EXPECT_THROW(read("\"none.png\" \"bad.png\"", true), Error);
  EXPECT_EQ(read("\"none.png\" \"good.png\"", true).warnings.size(), 0u);
}

TEST_F(X3dFilesTest, PicturesMayStandInTheUrl) {
  const auto read = [&](const std::string& url) {
    return read_scene(write("main.x3dv",
                            "Shape { geometry Box { } appearance Appearance { texture "
                            "ImageTexture { url \"" +
                                url + "\" } } }"),
                      picky_decoders());
  };
  const LoadedScene good = read("data:image/png;base64,Z29v\n ZA==");
  EXPECT_EQ(good.warnings.size(), 0u);
  EXPECT_EQ(good.scene.textures(0).image().width(), 1u);
  EXPECT_EQ(good.scene.textures(0).image().file(), "main.x3dv#picture 1");
  for (const std::string wrong :
       {"data:image/png;base64,", "data:image/png;base64,?", "data:text,"}) {
    const LoadedScene bad = read(wrong + std::string(1000, 'A'));
    ASSERT_EQ(bad.warnings.size(), 1u);
    EXPECT_EQ(bad.scene.textures(0).image().width(), 2u) << "the placeholder";
    EXPECT_NE(bad.warnings[0].find("AAAA...': "), std::string::npos) << bad.warnings[0];
    EXPECT_LT(bad.warnings[0].size(), folder_.string().size() + 250) << bad.warnings[0];
  }
}

TEST_F(X3dFilesTest, TheFirstInlineThatCanBeReadIsTaken) {
  std::ofstream(folder_ / "broken.x3dv") << "#X3D V3.3 utf8\nShape { geometry Box {";
  write("good.x3dv", "Shape { geometry Box { } }");
  const LoadedScene loaded =
      read_x3d(write("main.x3dv", "Inline { url [ \"broken.x3dv\" \"good.x3dv\" ] }"), {});
  EXPECT_EQ(loaded.scene.nodes(0).instance_of(), "good");
  const LoadedScene none =
      read_x3d(write("main.x3dv", "Inline { url [ \"broken.x3dv\" \"none.x3dv\" ] }"), {});
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_NE(none.warnings[0].find("Inline of 'broken.x3dv' is left out: "), std::string::npos);
  EXPECT_NE(none.warnings[0].find("; 'none.x3dv': there is no such file"), std::string::npos);
}

}  // namespace
}  // namespace tessera
