// The three encodings.
#include <gtest/gtest.h>

#include "proto/wire/scene_codec.h"
#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

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
                "t.x3d:4:25: transparency of Material: '2'; expected 0 to 1; 1 is taken",
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
                  "t.wrl:6:11: skyAngle of Background: 1 angle for 1 colour; expected one angle "
                  "fewer than colours; what is left over is left out",
                  "t.wrl:8:12: rotation of Transform: '0 0 0 1'; expected an axis other than "
                  "0 0 0; it is left out",
                  "t.wrl:9:20: color of PointLight: '2 0 0'; expected 0 to 1; the nearest colour "
                  "is taken",
                  "t.wrl:9:42: radius is given twice in PointLight; expected one value; the first "
                  "one is taken"}))
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
  EXPECT_EQ(x3d_error(nested(100)).substr(0, 8), "t.wrl:2:");
}

TEST(X3dEncodings, GroupsOfPrototypesEndWithAPlace) {
  std::string text = "#X3D V3.3 utf8\nPROTO P0 [ ] { Group { children Shape { } } }";
  for (int i = 1; i < 190; ++i) {
    const std::string before = std::to_string(i - 1);
    text += "\nPROTO P" + std::to_string(i) + " [ ] { Group { children P" + before + " { } } }";
  }
  EXPECT_EQ(x3d_error(text + "P189 { }").substr(0, 37), "t.wrl:16:17: groups nested too deep; ");
}

TEST(X3dEncodings, AreToldApartByTheirFirstBytes) {
  EXPECT_EQ(x3d_error("#VRML V1.0 ascii\nSeparator { }"),
            "t.wrl:1:1: VRML 1.0, a different language; expected VRML 2.0 (VRML97) or X3D");
  EXPECT_EQ(x3d_error("Shape { }").substr(0, 50),
            "t.wrl:1:1: a file that does not say what it is; ex");
  EXPECT_EQ(x3d_error("\x1f\x8bxx"), "t.wrl: broken gzip data; expected a whole gzipped file");
  const std::string gzip = gzipped_empty_scene();
  EXPECT_EQ(parse_x3d(gzip, "a.x3dz", {}).scene.cameras_size(), 1);
  for (size_t size = 2; size < gzip.size(); ++size)
    EXPECT_EQ(x3d_error(gzip.substr(0, size)),
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
  const auto of = [](const std::string& scene) { return x3d_error("#X3D V3.3 utf8\n" + scene); };
  EXPECT_EQ(of("Shape {"), "t.wrl:2:8: the end of the file; expected a field, or '}'");
  EXPECT_EQ(of("Shape }"), "t.wrl:2:7: '}'; expected '{'");
  EXPECT_EQ(of("Shape { geometry 7 }").substr(0, 11), "no error");
  EXPECT_EQ(of("\n  Sphere { radius \"x }"),
            "t.wrl:3:19: a string without an end; expected a "
            "closing quote");
  EXPECT_EQ(of("Transform { children [ Shape { } } ]").substr(0, 12), "t.wrl:2:34: ");
  std::string deep;
  for (int i = 0; i < 100; ++i) deep += "Group { children ";
  EXPECT_NE(of(deep).find("nodes nested too deep; expected at most 80 levels"), std::string::npos);
}

TEST(X3dEncodings, OnePartOfTheClassicOneThatCannotBeReadDoesNotCostTheFile) {
  struct Case {
    std::string part, warning;
  };
  const std::vector<Case> cases{
      {"Shape { geometry Sphere { radius 1x } }",
       "2:34: radius of Sphere: '1x'; expected a number; the field is left out"},
      {"Transform { translation nan 0 0 }",
       "2:25: translation of Transform: 'nan'; expected a finite number; the field is left out"},
      {"Transform { translation 0 Infinity 0 }",
       "2:27: translation of Transform: 'Infinity'; expected a finite number; the field is left "
       "out"},
      {"Background { skyColor [ nan 0, 1 ] }",
       "2:25: skyColor of Background: 'nan'; expected a finite number; 0 is taken"},
      {"DEF A Group { } USE B",
       "2:21: USE of 'B', which is not defined; expected the DEF name of a node "
       "before it; it is left out"},
      {"DEF G Group { children USE G }",
       "2:28: USE of 'G' inside itself; expected a graph without cycles; it is left out"},
      {"UNIT length furlong -1",
       "2:21: a length unit of '-1'; expected a factor above 0 in the range of single precision; "
       "it is left out"},
      {"Viewpoint { description 7 }",
       "2:25: description of Viewpoint: '7'; expected a string in quotes; it is taken for one"},
  };
  for (const Case& c : cases) {
    const auto loaded = parse_classic(c.part + " Shape { geometry Box { } }");
    EXPECT_TRUE(loaded.scene.nodes(loaded.scene.nodes_size() - 1).shape().has_box()) << c.part;
    EXPECT_EQ(loaded.warnings, std::vector<std::string>{"t.x3dv:" + c.warning}) << c.part;
  }
}

TEST(X3dEncodings, AWordForAValueCostsThatValueOnly) {
  struct Case {
    std::string part;
    std::vector<std::string> warnings;
  };
  const std::string stray = "; expected the name of a field or a node; it is left out";
  const std::vector<Case> cases{
      {"Shape { geometry Sphere { radius foo } }",
       {"2:34: radius of Sphere: 'foo'; expected a number; the field is left out"}},
      {"Shape { geometry Sphere { radius } }",
       {"2:34: radius without a value; expected one before '}'; it is left out"}},
      {"Shape { geometry Sphere { solid FLASE } }",
       {"2:33: solid of Sphere: 'FLASE'; expected true or false; true is taken"}},
      {"Background { skyColor [ abc 0 0 ] }",
       {"2:25: skyColor of Background: 'abc'; expected a number; 0 is taken"}},
      {"Switch { whichChoice foo }",
       {"2:22: whichChoice of Switch: 'foo'; expected a 32-bit integer; the field is left out"}},
      {"NavigationInfo { headlight NULL }",
       {"2:28: headlight of NavigationInfo: 'NULL'; expected true or false; true is taken"}},
      {"Shape { geometry NULL appearance foo }",
       {"2:34: appearance of Shape: 'foo'; expected a node; it is left out"}},
      {"Viewpoint { description Box { } }",
       {"2:25: description of Viewpoint: Box; expected a value; it is left out"}},
      {"Group { children [ foo Group { } bar ] }",
       {"2:20: 'foo' among nodes; expected nodes only; it is left out"}},
      {"Group { children Cone { } }",
       {"2:18: Cone among children; expected a Shape, a group, a light or a viewpoint; it is left "
        "out"}},
      {"Viewpoint { description \"a\" \"b\" }", {"2:29: '\"b\"'" + stray}},
      {"TRUE", {"2:1: 'TRUE'" + stray}},
      {"META title foo",
       {"2:6: META without two strings; expected a name and a content in quotes; it is left out"}},
      {"UNIT length m foo",
       {"2:15: a length unit of 'foo'; expected a factor above 0 in the range of single "
        "precision; it is left out"}},
      {"UNIT \"length\" m 3",
       {"2:17: a unit of '\"length\"'; expected angle, force, length or mass; it is left out"}},
      {"PROTO P [ field SFInt32 n 1 foo ] { Switch { whichChoice IS n } } P { }",
       {"2:29: 'foo'" + stray}},
      {"DEF 1a Group { } USE 1a", {}},
  };
  for (const Case& c : cases) {
    for (const std::string version : {"3.3", "VRML"}) {
      const LoadedScene loaded = parse_classic(c.part + " Shape { geometry Box { } }", version);
      EXPECT_TRUE(loaded.scene.nodes(loaded.scene.nodes_size() - 1).shape().has_box()) << c.part;
      std::vector<std::string> expected;
      for (const std::string& warning : c.warnings) expected.push_back("t.x3dv:" + warning);
      EXPECT_EQ(loaded.warnings, expected) << c.part;
      EXPECT_EQ(loaded.repairs.size(), expected.size()) << c.part;
    }
  }
  // What stands beside the word is read.
  EXPECT_EQ(parse_classic("Shape { geometry Cylinder { radius foo height 3 } }")
                .scene.nodes(0)
                .shape()
                .cylinder()
                .height(),
            3);
  EXPECT_EQ(
      parse_classic("Group { children [ foo Group { } bar ] }").scene.nodes(0).children_size(), 1);
  EXPECT_EQ(parse_classic("Viewpoint { description \"a\" \"b\" }").scene.cameras(0).description(),
            "a");
}

TEST(X3dEncodings, ElementsThatAreNotReadAreTold) {
  const std::string box = "<Shape><Box/></Shape>", not_read = "; it is not read";
  const std::string head_or_scene = "; expected one head and one Scene in X3D" + not_read;
  struct Case {
    std::string text, warning;
  };
  for (const Case& c : std::vector<Case>{
           {"<X3D><Scene>" + box + "</Scene>\n<Scene><Group/></Scene></X3D>",
            "2:2: another 'Scene'" + head_or_scene},
           {"<X3D><Scene>" + box + "</Scene>\n<Shape/></X3D>",
            "2:2: an element 'Shape'" + head_or_scene},
           {"<X3D><Scene>" + box + "</Scene></X3D>\n<X3D><Scene><Group/></Scene></X3D>",
            "2:2: another 'X3D'; expected one X3D in a file" + not_read},
           {"<X3D><head><meta name='a' content='b'/><meta name='c' content='d'/>\n<Group/></head>"
            "<Scene>" +
                box + "</Scene></X3D>",
            "2:2: an element 'Group'; expected component, unit or meta in head" + not_read},
           {"<X3D><Scene><ProtoDeclare name='P'><ProtoBody><Group/></ProtoBody>\n<ProtoBody/>"
            "</ProtoDeclare>" +
                box + "</Scene></X3D>",
            "2:2: another 'ProtoBody'; expected one of each part of ProtoDeclare" + not_read},
           {"<X3D><Scene>" + box + "\n0 1</Scene></X3D>",
            "2:1: text in Scene; expected attributes and elements" + not_read},
           {"<X3D><Scene>\n<Sphere/>" + box + "</Scene></X3D>",
            "2:2: unknown field 'geometry' of Scene is left out"},
       }) {
    const LoadedScene loaded = parse_x3d(c.text, "t.x3d", {});
    ASSERT_EQ(loaded.scene.nodes_size(), 1) << c.text;
    EXPECT_TRUE(loaded.scene.nodes(0).shape().has_box());
    EXPECT_EQ(loaded.warnings, std::vector<std::string>{"t.x3d:" + c.warning}) << c.text;
  }
}

TEST(X3dEncodings, AUnitOutOfRangeIsLeftOut) {
  for (const std::string factor : {"1e300", "1e-300", "0", "1.2.3", "nan", ""}) {
    const LoadedScene loaded = parse_x3d("<X3D><head>\n<unit category='length' conversionFactor='" +
                                             factor + "'/></head><Scene><Group/></Scene></X3D>",
                                         "t.x3d", {});
    EXPECT_EQ(loaded.warnings,
              std::vector<std::string>{"t.x3d:2:43: a length unit of '" + factor +
                                       "'; expected a factor above 0 in the range of single "
                                       "precision; it is left out"});
    EXPECT_FALSE(loaded.scene.nodes(0).has_transform());
  }
}

TEST(X3dEncodings, OfAnAttributeGivenTwiceTheFirstIsTaken) {
  const LoadedScene loaded = parse_x3d(
      "<X3D version='3.3'><Scene><Group DEF='a' DEF='b'/>\n"
      "<Shape><Sphere radius='3' solid='true' radius='2'/></Shape></Scene></X3D>",
      "t.x3d", {});
  EXPECT_EQ(loaded.scene.nodes(0).name(), "a");
  EXPECT_EQ(loaded.scene.nodes(1).shape().sphere().radius(), 3);
  EXPECT_EQ(loaded.warnings,
            std::vector<std::string>{"t.x3d:1:47: DEF is given twice in Group; expected one value; "
                                     "the first one is taken (2 times)"});
  std::string many = "<X3D><Scene><Group";
  for (int i = 0; i < 100'000; ++i) many += " a" + std::to_string(i) + "=''";
  EXPECT_EQ(parse_x3d(many + "/></Scene></X3D>", "t.x3d", {}).scene.nodes_size(), 1);
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
  EXPECT_EQ(warnings[0],
            "t.x3dv:2:24: intensity of PointLight: '-1'; expected 0 or more; 0 is taken");
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

TEST(X3dEncodings, TellsOfAnUnknownNodeOnceWhateverFieldHoldsIt) {
  const std::vector<std::string> expected{
      "3:1: unknown node 'BlendMode' is left out",
      "4:1: unknown node 'Foo' is left out; did you mean 'Fog'?"};
  const auto in = [](const std::string& file, std::vector<std::string> warnings) {
    for (std::string& warning : warnings) warning.erase(0, file.size() + 1);
    return warnings;
  };
  EXPECT_EQ(in("t.x3dv", parse_classic("Shape { appearance Appearance { blendMode\nBlendMode { } } "
                                       "geometry Box { } bboxSize\nFoo { } }")
                             .warnings),
            expected);
  EXPECT_EQ(in("t.x3d", parse_x3d("<X3D><Scene><Shape><Appearance>\n\n<BlendMode "
                                  "containerField='blendMode'/></Appearance>\n<Foo/><Box/></Shape>"
                                  "</Scene></X3D>",
                                  "t.x3d", {})
                            .warnings),
            (std::vector<std::string>{"3:2: unknown node 'BlendMode' is left out",
                                      "4:2: unknown node 'Foo' is left out; did you mean 'Fog'?"}));
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

TEST(X3dEncodings, SaysWhatIsGivenTwice) {
  const auto loaded =
      parse_classic("Shape { geometry Box { } geometry Sphere { radius 1 radius 2 } }");
  EXPECT_TRUE(loaded.scene.nodes(0).shape().has_sphere());
  ASSERT_EQ(loaded.warnings.size(), 2u);
  EXPECT_EQ(loaded.warnings[0],
            "t.x3dv:2:35: geometry of Shape: a second node; expected one; the last one is taken");
  EXPECT_EQ(
      loaded.warnings[1],
      "t.x3dv:2:60: radius is given twice in Sphere; expected one value; the first one is taken");
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
  EXPECT_NE(x3d_error(text).find(
                "lists that are used too often; expected at most 256 MiB, and 16 times the "
                "file, read in all"),
            std::string::npos);
}

TEST(X3dEncodings, AUseInsideANodeMeansAnEarlierOneOfThatName) {
  const std::string red = "Shape { appearance Appearance { material DEF pin Material { ";
  const auto classic = parse_classic(
      red +
          "diffuseColor 1 0 0 } } geometry Box { } } DEF pin Transform { children DEF pin Shape { "
          "appearance Appearance { material USE pin } geometry Sphere { } } } USE pin",
      "VRML");
  const auto xml = parse_x3d(
      "<X3D version='3.3'><Scene><Shape><Appearance><Material DEF='pin' diffuseColor='1 0 0'/>"
      "</Appearance><Box/></Shape><Transform DEF='pin'><Shape DEF='pin'><Appearance><Material "
      "USE='pin'/></Appearance><Sphere/></Shape></Transform><Shape USE='pin'/></Scene></X3D>",
      "t.x3d", {});
  for (const LoadedScene& loaded : {std::cref(classic), std::cref(xml)}) {
    EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
    EXPECT_EQ(loaded.scene.materials_size(), 2) << "one a shape";
    for (const v1::Material& material : loaded.scene.materials())
      EXPECT_EQ(material.classic().diffuse().value().r(), 1);
    ASSERT_EQ(loaded.scene.nodes_size(), 3);
    EXPECT_NE(loaded.scene.nodes(2).instance_of(), "") << "the last node of that name";
  }
}

TEST(X3dEncodings, AScriptMayReferToWhatItIsAPartOf) {
  const std::vector<std::string> ignored{"t.x3dv: ignored: 1 Script"};
  EXPECT_EQ(parse_classic("DEF S Script { field SFNode self USE S }", "VRML").warnings, ignored);
  EXPECT_EQ(
      parse_classic("DEF G Group { children Script { field SFNode self USE G } }", "VRML").warnings,
      ignored);
  EXPECT_EQ(parse_x3d("<X3D><Scene><Script DEF='S'><field name='self' type='SFNode'><Script "
                      "USE='S'/></field></Script></Scene></X3D>",
                      "t.x3d", {})
                .warnings,
            std::vector<std::string>{"t.x3d: ignored: 1 Script, 1 field"});
  EXPECT_EQ(
      parse_classic("DEF S Script { } DEF G Group { children USE G }", "VRML").warnings.size(), 2u)
      << "what follows a Script is no part of it";
}

}  // namespace
}  // namespace tessera
