#include "scenes/edit/x3d_rotation.h"

#include <numbers>

#include "scenes/formats/x3d/x3d_reader.h"
#include "scenes/import/to_affine.h"
#include "tests/unit/scenes/edit/placement_testing.h"

namespace tessera::edit {
namespace {

constexpr Language kXml = Language::x3d, kClassic = Language::classic_x3d;

struct Frame {
  Language language;
  std::string begin, end;
};
const Frame kXmlFrame{kXml, "\xEF\xBB\xBF<X3D version='4.0'>\r\n<Scene><!-- é -->\r\n  ",
                      "\r\n</Scene></X3D>\r\n"};
const Frame kClassicFrame{kClassic, "#X3D V4.0 utf8\nPROFILE Full\nGroup { children [\n  ",
                          "\n] } # end\n"};

std::string document(const Frame& frame, const std::string& body) {
  return frame.begin + body + frame.end;
}

/// What stands in the document after its first model got that placement.
std::string placed_in(const Frame& frame, const std::string& body, const Placement& placement) {
  const std::string made = placed(frame.language, document(frame, body), placement);
  EXPECT_TRUE(made.starts_with(frame.begin) && made.ends_with(frame.end)) << made;
  return made.substr(frame.begin.size(), made.size() - frame.begin.size() - frame.end.size());
}

WrittenPlacement read_in(const Frame& frame, const std::string& body) {
  return read_include(frame.language, document(frame, body));
}

std::string fault_in(const Frame& frame, const std::string& body, const Placement& placement) {
  return fault(frame.language, document(frame, body), placement);
}

const std::string kInline = "<Inline url='\"a.obj\"'/>", kNode = "Inline { url \"a.obj\" }";
const Placement kNone{.file = "a.obj", .material = ""};

TEST(StudioEdit, TheAxisOfAboutHalfATurnIsExact) {
  for (const double less : {0., 1e-9, 1e-6, 3e-5, 9e-5, 1.1e-4, 1e-2}) {
    for (const Vec3& axis : {Vec3{1, 2, -3}, Vec3{0, 0, 1}, Vec3{-1, 1e-3, 0}}) {
      const Affine wanted = rotation(normalize(axis), std::numbers::pi - less);
      EXPECT_LE(rotation_difference(wanted, rotation_of(axis_angle(wanted))), 1e-11) << less;
    }
  }
}

TEST(X3dPlacement, IsReadFromItsTransform) {
  const WrittenPlacement some = read_in(
      kXmlFrame, "<Transform translation='1,-2.50 0' rotation='0 -2 0 1.570796' scale='-2 .5 3'>" +
                     kInline + "</Transform>");
  EXPECT_EQ(some.locked, "");
  EXPECT_FALSE(some.has_material);
  const Placement wanted{.file = "a.obj",
                         .material = "",
                         .position = {"1", "-2.50", "0"},
                         .rotation = {"0", "-90", "0"},
                         .scale = {"2", ".5", "3"},
                         .flip = {true, false, false}};
  expect_same(some.placement, wanted);
  expect_same(read_in(kClassicFrame,
                      "Transform { translation 1 -2.50 0 rotation 0 -2 0 1.570796 scale -2 .5 3 "
                      "children [ " +
                          kNode + " ] }")
                  .placement,
              wanted);
  EXPECT_FALSE(read_placement(outline(kXml, document(kXmlFrame, "")), 0).has_material);
  // What holds others or moves the centre is the frame that the model stands in.
  for (const std::string& holder : std::initializer_list<std::string>{
           "<Transform translation='1 0 0' center='0 1 0'>" + kInline + "</Transform>",
           "<Transform translation='1 0 0' scaleOrientation='0 1 0 1'>" + kInline + "</Transform>",
           "<Transform translation='1 0 0'>" + kInline + "<Shape/></Transform>",
           "<Group><Transform/>" + kInline + "</Group>", kInline})
    expect_same(read_in(kXmlFrame, holder).placement, kNone);
}

TEST(X3dPlacement, WrapsTheInlineOfAnXmlText) {
  Placement some = kNone;
  EXPECT_EQ(placed_in(kXmlFrame, kInline, some), kInline);
  some.file = "b.obj";
  EXPECT_EQ(placed_in(kXmlFrame, kInline, some), "<Inline url='\"b.obj\"'/>");
  some = kNone;
  some.position = {"1", "+.50", "0"};
  some.rotation = {"0", "90", "0"};
  some.flip = {true, false, false};
  const std::string tag =
      "<Transform translation='1 0.50 0' rotation='0 1 0 1.570796' scale='-1 1 1'>";
  EXPECT_EQ(placed_in(kXmlFrame, kInline, some), tag + "\r\n    " + kInline + "\r\n  </Transform>");
  EXPECT_EQ(placed_in(kXmlFrame, "<Group>" + kInline + "</Group>", some),
            "<Group>" + tag + kInline + "</Transform></Group>");
  // The lines of one that has several stay as they are.
  EXPECT_EQ(
      placed_in(kXmlFrame, "<Inline DEF='a'\r\n    url='\"a.obj\"'>\r\n  </Inline>", some),
      tag + "\r\n    <Inline DEF='a'\r\n    url='\"a.obj\"'>\r\n  </Inline>\r\n  </Transform>");
  EXPECT_EQ(placed_in(kXmlFrame, "<Transform center='0 1 0'>" + kInline + "</Transform>", some),
            "<Transform center='0 1 0'>" + tag + kInline + "</Transform></Transform>");
}

TEST(X3dPlacement, WrapsTheInlineOfAClassicText) {
  Placement some = kNone;
  EXPECT_EQ(placed_in(kClassicFrame, kNode, some), kNode);
  some.position = {"1", "0", "0"};
  some.scale = {"2", "2", "2"};
  EXPECT_EQ(
      placed_in(kClassicFrame, kNode + " # a", some),
      "Transform {\n    translation 1 0 0\n    scale 2 2 2\n    children " + kNode + " # a\n  }");
  EXPECT_EQ(placed_in(kClassicFrame, "Group { children DEF x " + kNode + " }", some),
            "Group { children Transform { translation 1 0 0 scale 2 2 2 children DEF x " + kNode +
                " } }");
  EXPECT_EQ(
      placed_in(kClassicFrame, "Group { children " + kNode + " }", some),
      "Group { children Transform { translation 1 0 0 scale 2 2 2 children " + kNode + " } }");
  EXPECT_EQ(placed_in(kClassicFrame, "Transform { children " + kNode + " }", some),
            "Transform { translation 1 0 0 scale 2 2 2 children " + kNode + " }");
}

TEST(X3dPlacement, ChangesTheLiteralsThatDiffer) {
  const std::string begin = "<Transform  rotation=\"0 1 0 1.5708\" translation = \"1.0, 2 3\" >";
  const std::string end = " <!-- a -->" + kInline + "</Transform>";
  Placement some = read_in(kXmlFrame, begin + end).placement;
  EXPECT_EQ(some.rotation[1], "90.0002");
  some.position = {"1", "2.0", "4"};
  EXPECT_EQ(placed_in(kXmlFrame, begin + end, some),
            "<Transform  rotation=\"0 1 0 1.5708\" translation = \"1.0, 2 4\" >" + end);
  some.position = {"1", "2", "3"};
  some.rotation[1] = "45";
  EXPECT_EQ(placed_in(kXmlFrame, begin + end, some),
            "<Transform  rotation=\"0 1 0 0.785398\" translation = \"1.0, 2 3\" >" + end);
}

TEST(X3dPlacement, ARotationAboutAnAxisComesBackAsItWasTyped) {
  for (const char* const typed : {"90", "-90", "45", "180", "-180", "270", "360", "-450", "30",
                                  "33.333333", "0.001", "1e-9", "0.1234567891", "123456"}) {
    for (size_t axis = 0; axis < 3; ++axis) {
      std::array<std::string, 3> degrees{"0", "0", "0"};
      degrees[axis] = typed;
      const auto shown = shown_degrees(written_degrees(degrees));
      ASSERT_TRUE(shown.has_value());
      EXPECT_EQ(numbers_of(*shown), numbers_of(degrees)) << typed << written_degrees(degrees);
    }
  }
  EXPECT_EQ(written_degrees({"0", "0", "0"}), "0 0 1 0");
  EXPECT_EQ(written_degrees({"0", "90", "0"}), "0 1 0 1.570796");
  EXPECT_EQ(shown_degrees("0 1 0"), std::nullopt);
  EXPECT_EQ(shown_degrees("0 1 0 a"), std::nullopt);
  // An angle of few digits is no rounded one.
  EXPECT_EQ((*shown_degrees("0 0 1 1"))[2], "57.2958");
  // Where y is a quarter of a turn, x and z turn about one axis.
  const std::array<std::string, 3> upright{"0", "90", "30"};
  const auto shown = *shown_degrees(written_degrees(upright));
  EXPECT_EQ(numbers_of(shown), (Vec3{30, 90, 0}));
}

TEST(X3dPlacement, IsLockedWhereOtherPlacesWouldChange) {
  const std::string shared = "'t' around it is used in other places, which would change, too";
  const std::string other = "the translation of its Transform cannot be read";
  const std::string unit = "the document has a unit of its own for angles";
  const std::pair<std::string, std::string> cases[] = {
      {"<Transform DEF='t' translation='1 0 0'>" + kInline + "</Transform><Transform USE='t'/>",
       shared},
      {"<Group DEF='t'><Group>" + kInline + "</Group></Group><Group USE='t'/>", shared},
      {"<Transform translation='1 0'>" + kInline + "</Transform>", other},
      {"<Transform translation='a b c'>" + kInline + "</Transform>", other},
      {kInline + "<unit category='angle' conversionFactor='.01'/>", unit}};
  for (const auto& [body, locked] : cases) {
    SCOPED_TRACE(body);
    EXPECT_EQ(read_in(kXmlFrame, body).locked, locked);
    EXPECT_EQ(fault_in(kXmlFrame, body, kNone), locked + "; a placement");
  }
  EXPECT_EQ(read_in(kClassicFrame, "DEF t Group { children " + kNode + " } USE t").locked, shared);
  EXPECT_EQ(read_include(kClassic, "#X3D V4.0 utf8\nUNIT angle degree .01\n" + kNode).locked, unit);
  EXPECT_EQ(read_in(kXmlFrame, kInline + "<unit category='length' conversionFactor='.01'/>").locked,
            "");
}

TEST(X3dPlacement, AUseOfAModelHasAPlaceOfItsOwn) {
  const std::string first = "<Inline DEF='a' url='\"a.obj\"'/>", use = "<Inline USE='a'/>";
  Placement some = kNone;
  some.position = {"1", "0", "0"};
  const std::string begin = "<Transform translation='1 0 0'>", end = "</Transform>";
  EXPECT_EQ(placed_in(kXmlFrame, first + use, some), begin + first + end + use);
  const Outline made = outline(kXml, document(kXmlFrame, first + use));
  const int second = include_of(made) + 1;
  expect_same(read_placement(made, second).placement, kNone);
  EXPECT_EQ(applied(made, set_placement(made, second, some)),
            document(kXmlFrame, first + begin + use + end));
  some.file = "b.obj";
  EXPECT_EQ(fault_in(kXmlFrame, first + use, some),
            "'a', which other models have, too; a file of this model alone");
  EXPECT_FALSE(set_placement(made, second, some).is_made());
}

TEST(X3dPlacement, HasNoMaterial) {
  Placement some = kNone;
  some.material = "red";
  const std::string refusal = "the material 'red'; none, as the language has none for a model";
  EXPECT_EQ(fault_in(kXmlFrame, kInline, some), refusal);
  EXPECT_EQ(refusal_of(add_placement(outline(kXml, document(kXmlFrame, kInline)), some)), refusal);
  EXPECT_NE(fault_in(kXmlFrame, "<Inline url='\"a.obj\"'>",
                     {.file = "a.obj", .material = "", .position = {"1", "0", "0"}}),
            "none");
}

TEST(X3dPlacement, IsAddedWithItsModel) {
  const Placement some{.file = "b.obj", .material = "", .position = {"1", "0", "0"}};
  EXPECT_EQ(added(kXml, document(kXmlFrame, kInline), some),
            document(kXmlFrame, kInline + "\r\n  <Transform translation='1 0 0'>\r\n    <Inline "
                                          "url='\"b.obj\"'/>\r\n  </Transform>"));
  EXPECT_EQ(added(kClassic, "#X3D V4.0 utf8\n" + kNode + "\n", some),
            "#X3D V4.0 utf8\n" + kNode +
                "\nTransform {\n  translation 1 0 0\n  children Inline { url \"b.obj\" }\n}\n");
}

/// What the reader makes of all that is around a document's first model.
Affine read_matrix(const std::string& text) {
  const LoadedScene read = parse_x3d(text, "made.x3d", {});
  Affine matrix;
  const v1::Node* node = &read.scene.nodes(0);
  for (;; node = &node->children(0)) {
    matrix = matrix * to_affine(node->transform());
    if (node->children_size() == 0) return matrix;
  }
}

TEST(X3dPlacement, RandomOnesComeBackAndAreWhatTheReaderMakes) {
  for (const Frame& frame : {kXmlFrame, kClassicFrame}) {
    const std::string first = document(frame, frame.language == kXml ? kInline : kNode);
    for (uint64_t seed = 0; seed < 200; ++seed) {
      SCOPED_TRACE(fmt::format("seed {}", seed));
      std::string text = first;
      for (const uint64_t each : {seed, seed + 1000}) {
        const Placement wanted = random_placement(each);
        text = placed(frame.language, text, wanted);
        const Placement got = read_include(frame.language, text).placement;
        EXPECT_EQ(numbers_of(got.position), numbers_of(wanted.position));
        EXPECT_EQ(signed_numbers_of_scale(got), signed_numbers_of_scale(wanted));
        EXPECT_LE(rotation_difference(rotation_of_degrees(got.rotation),
                                      rotation_of_degrees(wanted.rotation)),
                  2 * kSameRotation);
        EXPECT_EQ(placed(frame.language, text, wanted), text);
        EXPECT_EQ(placed(frame.language, text, got), text);
        const double size = std::max({1.0, numbers_of(wanted.scale).x, numbers_of(wanted.scale).y,
                                      numbers_of(wanted.scale).z});
        EXPECT_LE(largest_difference(read_matrix(text), matrix_of(wanted, true)),
                  1.001 * kSameRotation * size)
            << text;
      }
      text = placed(frame.language, text, kNone);
      EXPECT_LE(largest_difference(read_matrix(text), Affine{}), 1e-12);
    }
  }
}

}  // namespace
}  // namespace tessera::edit
