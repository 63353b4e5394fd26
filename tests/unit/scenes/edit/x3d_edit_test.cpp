#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "renderer/camera/camera.h"
#include "scenes/formats/x3d/x3d_reader.h"
#include "scenes/import/to_affine.h"
#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

Outline x3d_text(const std::string& text) { return outline(Language::x3d, text); }

int entity_named(const Outline& outline, std::string_view name) {
  for (size_t i = 0; i < outline.entities().size(); ++i)
    if (outline.entities()[i].name == name || outline.entities()[i].type == name)
      return static_cast<int>(i);
  ADD_FAILURE() << "no entity " << name;
  return 0;
}

std::string set(const std::string& text, std::string_view entity, std::string_view field,
                std::string_view value) {
  const Outline made = x3d_text(text);
  return applied(made, set_field(made, entity_named(made, entity), field, value));
}

std::string other_value(const Field& field) {
  if (field.kind == ValueKind::boolean) return field.text == "true" ? "false" : "true";
  if (field.kind != ValueKind::number) {
    // Another first number of as many.
    const size_t end = field.text.find_first_of(" ,\n");
    return (field.text.starts_with("0.5") ? ".25" : ".5") +
           (end == std::string::npos ? "" : field.text.substr(end));
  }
  return field.text == "0.5" ? "0.25" : "0.5";
}

TEST(StudioEdit, SetsTheNumbersOfEveryX3dSample) {
  for (const SampleText& sample : samples(".x3d")) {
    SCOPED_TRACE(sample.name);
    const Outline outline = x3d_text(sample.text);
    expect_nested(outline);
    size_t count = 0;
    for (size_t i = 0; i < outline.entities().size(); ++i) {
      for (const Field& field : outline.entities()[i].fields) {
        const bool is_number = field.kind == ValueKind::number || field.kind == ValueKind::vector ||
                               field.kind == ValueKind::color || field.kind == ValueKind::boolean;
        if (!is_number || !field.locked.empty() || field.name == "coordIndex") continue;
        SCOPED_TRACE(outline.entities()[i].path + " " + field.name + " = " + field.text);
        const std::string value = other_value(field);
        const Change change = set_field(outline, static_cast<int>(i), field.name, value);
        ASSERT_TRUE(change.is_made()) << refusal_of(change);
        ASSERT_EQ(change.edits.size(), 1u);
        ASSERT_TRUE(field.value.contains(change.edits[0].range));
        const std::string made = apply_edits(outline.text(), change.edits);
        ASSERT_EQ(apply_edits(made, inverse_edits(outline.text(), change.edits)), outline.text());
        EXPECT_NO_THROW(parse_x3d(made, "made.x3d", {}));
        ++count;
      }
    }
    EXPECT_GT(count, 50u);
  }
}

TEST(StudioEdit, NoWordInAnX3dFieldMakesTheTextUnreadable) {
  const std::string text =
      "<X3D><Scene><Fog visibilityRange='9'/><Background/><NavigationInfo/><Viewpoint/>"
      "<DirectionalLight/><PointLight/><SpotLight/><Transform DEF='t'><Shape><Appearance>"
      "<Material/><ImageTexture/></Appearance><Sphere/></Shape><Shape><Appearance>"
      "<PhysicalMaterial/></Appearance><Box/></Shape><Shape><Cylinder/></Shape><Shape><Cone/>"
      "</Shape><Shape><Disk2D/></Shape></Transform></Scene></X3D>";
  const Outline made = x3d_text(text);
  ASSERT_NO_THROW(parse_x3d(text, "made.x3d", {}));
  size_t refused = 0;
  for (size_t i = 0; i < made.entities().size(); ++i) {
    for (const Field& field : all_fields(made, static_cast<int>(i))) {
      if (!field.locked.empty() || field.kind == ValueKind::file || field.name == "USE") continue;
      SCOPED_TRACE(made.entities()[i].path + " " + field.name);
      const Change change = set_field(made, static_cast<int>(i), field.name, "sometimes");
      refused += !change.is_made();
      if (!change.is_made()) continue;
      EXPECT_NO_THROW(parse_x3d(apply_edits(text, change.edits), "made.x3d", {}));
    }
  }
  EXPECT_GT(refused, 50u);
  EXPECT_NE(set(text, "Appearance", "alphaMode", "MASK").find("alphaMode='MASK'"),
            std::string::npos);
}

TEST(StudioEdit, KeepsQuotesAndEntitiesOfXml) {
  const std::string text =
      "<X3D><Scene>\r\n  <Viewpoint DEF='a' description='x &amp; y'/>\r\n</Scene></X3D>";
  EXPECT_EQ(set(text, "a", "position", "1 2 3"),
            "<X3D><Scene>\r\n  <Viewpoint DEF='a' description='x &amp; y' position='1 2 3'/>\r\n"
            "</Scene></X3D>");
  EXPECT_EQ(set(text, "a", "description", "x & y"), text);
  EXPECT_EQ(set(text, "a", "description", "it's <b>"),
            "<X3D><Scene>\r\n  <Viewpoint DEF='a' description='it&apos;s &lt;b>'/>\r\n"
            "</Scene></X3D>");
  const Outline made = x3d_text(text);
  EXPECT_FALSE(set_field(made, entity_named(made, "a"), "positon", "1 2 3").is_made());
  for (const char* const wrong : {"1 2", "nan 0 0", "1,5 2 3 4", ""})
    EXPECT_FALSE(set_field(made, entity_named(made, "a"), "position", wrong).is_made()) << wrong;
}

TEST(StudioEdit, CountsTheUsesOfADefinition) {
  const std::string text =
      "<X3D><Scene><Shape><Sphere DEF='s' radius='1'/></Shape><Shape><Sphere USE='s'/></Shape>"
      "</Scene></X3D>";
  const Outline made = x3d_text(text);
  EXPECT_EQ(set_field(made, entity_named(made, "s"), "radius", "2").changed, 2);
  EXPECT_FALSE(remove(made, entity_named(made, "s")).is_made());
}

TEST(StudioEdit, PlacesWhatItAddsToX3d) {
  const Outline made = x3d_text("<X3D><Scene>\n  <Group/>\n</Scene></X3D>\n");
  EntityTemplate sphere{"sphere", "Sphere", {{"radius", "2"}}, {{1.5, 0, -.25}}};
  const std::string text = applied(made, add(made, 0, sphere));
  EXPECT_NE(text.find("translation="), std::string::npos) << text;
  EXPECT_NE(text.find("1.5 0 -0.25"), std::string::npos) << text;
  const std::string placed = applied(made, add_include(made, "a.x3d", {{1, 2, 3}}));
  EXPECT_NE(placed.find("1 2 3"), std::string::npos) << placed;
  EXPECT_NE(placed.find("</Transform>"), std::string::npos) << placed;
}

TEST(StudioEdit, AddsToEveryX3dSample) {
  for (const SampleText& sample : samples(".x3d")) {
    const Outline outline = x3d_text(sample.text);
    const v1::Scene before = parse_x3d(sample.text, "made.x3d", {}).scene;
    for (const EntityTemplate& added : entity_templates(Language::x3d)) {
      if (added.type == "Inline") continue;
      const std::string made = applied(outline, add(outline, 0, added));
      const v1::Scene scene = parse_x3d(made, "made.x3d", {}).scene;
      EXPECT_NE(scene.ByteSizeLong(), before.ByteSizeLong()) << added.name;
    }
    for (size_t i = 1; i < outline.entities().size(); ++i) {
      const Change doubled = duplicate(outline, static_cast<int>(i));
      if (doubled.is_made()) expect_nested(x3d_text(applied(outline, doubled)));
      const Change removed = remove(outline, static_cast<int>(i));
      if (removed.is_made()) expect_nested(x3d_text(applied(outline, removed)));
    }
  }
}

RC_GTEST_PROP(StudioEdit, WritesTheViewpointOfAnX3dText, ()) {
  const auto numbers = *rc::gen::container<std::vector<int>>(9, rc::gen::inRange(-4000, 4000));
  CameraPose pose;
  for (size_t i = 0; i < 3; ++i) {
    pose.eye[i] = numbers[i] / 977.0;
    pose.target[i] = pose.eye[i] + numbers[i + 3] / 1013.0;
    pose.up[i] = numbers[i + 6] / 300.0;
  }
  pose.field_of_view = 33.3;
  const auto point = [](const std::array<double, 3>& t) { return Point3{t[0], t[1], t[2]}; };
  const Vec3 up{pose.up[0], pose.up[1], pose.up[2]};
  const Vec3 view = point(pose.target) - point(pose.eye);
  RC_PRE(length(view) > .1 && length(cross(view, up)) > .05 * length(view) * length(up));
  const Outline outline =
      x3d_text("<X3D version='4.0'>\n<Scene>\n  <Viewpoint/>\n</Scene>\n</X3D>\n");
  const std::string made = applied(outline, write_camera(outline, "", pose));
  const v1::Camera camera = parse_x3d(made, "made.x3d", {}).scene.cameras(0);
  const Affine wanted = look_at(point(pose.eye), point(pose.target), up);
  const Affine got = to_affine(camera.world_from_camera());
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c)
      RC_ASSERT(std::abs(wanted.m[r][c] - got.m[r][c]) <=
                2e-6 * (c == 3 ? std::max(1.0, length(view)) : 1));
  RC_ASSERT(std::abs(camera.perspective().field_of_view() - 33.3) < 1e-5);
  RC_ASSERT(write_camera(x3d_text(made), "", pose).edits.empty());
}

/// Of the frame of the camera that the text has first: its eye, and the directions of its axes.
std::array<Vec3, 4> first_frame(const std::string& text, Language language) {
  const char* const name = language == Language::x3d ? "made.x3d" : "made.x3dv";
  const Affine frame = to_affine(parse_x3d(text, name, {}).scene.cameras(0).world_from_camera());
  return {frame(Point3{}) - Point3{}, normalize(frame(Vec3{1, 0, 0})),
          normalize(frame(Vec3{0, 1, 0})), normalize(frame(Vec3{0, 0, 1}))};
}

TEST(StudioEdit, WritesTheCameraOfEveryX3dSampleWhateverItMeasuresIn) {
  for (const auto& [ending, language] :
       {std::pair{".x3d", Language::x3d}, std::pair{".x3dv", Language::classic_x3d}}) {
    for (const SampleText& sample : samples(ending)) {
      SCOPED_TRACE(sample.name);
      CameraPose pose{{1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, 40.0, "", {}};
      Outline made = outline(language, sample.text);
      const bool is_window =
          parse_x3d(sample.text, sample.name, {}).scene.cameras(0).has_orthographic();
      if (is_window) pose.orthographic = 5;
      const std::string text = applied(made, write_camera(made, "", pose));
      const Affine wanted = look_at({1, 2, 3}, {0, .5, 0}, {0, 1, 0});
      const auto got = first_frame(text, language);
      EXPECT_LT(length(got[0] - Vec3{1, 2, 3}), 1e-5);
      EXPECT_LT(length(got[1] - wanted(Vec3{1, 0, 0})), 1e-5);
      EXPECT_LT(length(got[3] - wanted(Vec3{0, 0, 1})), 1e-5);
      const v1::Camera camera = parse_x3d(text, sample.name, {}).scene.cameras(0);
      if (is_window) {
        EXPECT_EQ(camera.orthographic().max_y(), 2.5);
        EXPECT_EQ(camera.orthographic().min_x(), -2.5);
      } else {
        EXPECT_NEAR(camera.perspective().field_of_view(), 40, 1e-5);
      }
      made = outline(language, text);
      EXPECT_TRUE(write_camera(made, "", pose).edits.empty());
    }
  }
}

/// Whether the camera that the text has first sees from there, its right side on the right.
void expect_seen_from(const CameraPose& pose, const std::string& text, Language language) {
  SCOPED_TRACE(text);
  const auto point = [](const std::array<double, 3>& t) { return Point3{t[0], t[1], t[2]}; };
  const char* const name = language == Language::x3d ? "made.x3d" : "made.x3dv";
  CameraSettings settings;
  settings.world_from_camera =
      to_affine(parse_x3d(text, name, {}).scene.cameras(0).world_from_camera());
  const Camera got(settings, 16, 9);
  settings.world_from_camera =
      look_at(point(pose.eye), point(pose.target), point(pose.up) - Point3{});
  const Camera wanted(settings, 16, 9);
  EXPECT_LT(length(got.position() - wanted.position()), 5e-6);
  EXPECT_LT(length(got.view() - wanted.view()), 5e-6);
  EXPECT_LT(length(got.up() - wanted.up()), 5e-6);
  EXPECT_LT(length(got.right() - wanted.right()), 5e-6);
}

TEST(StudioEdit, WritesAViewpointInTheAxesOfTheTransformsAroundIt) {
  const CameraPose pose{{1, 2, 3}, {0, 0.5, 0.25}, {.1, 1, 0}, 40.0, "smaller", {}};
  const auto written = [&](const std::string& head, const std::string& transform) {
    const Outline made = x3d_text("<X3D version='3.3'>" + head + "<Scene><Transform " + transform +
                                  "><Viewpoint/></Transform></Scene></X3D>");
    const Change change = write_camera(made, "", pose);
    if (change.refusal) return change.refusal->found;
    const std::string text = applied(made, change);
    expect_seen_from(pose, text, Language::x3d);
    EXPECT_TRUE(write_camera(x3d_text(text), "", pose).edits.empty()) << text;
    return text;
  };
  EXPECT_NE(written("", "translation='10 20 30'").find("<Viewpoint position='-9 -18 -27' "),
            std::string::npos);
  EXPECT_NE(written("", "scale='2 2 2'").find("position='0.5 1 1.5'"), std::string::npos);
  EXPECT_NE(written("", "scale='7000 7000 7000'").find("position='0.0001428571 0.0002857143 "),
            std::string::npos)
      << "as near in the world, however long a unit is there";
  written("", "translation='1 2 3' rotation='1 2 3 0.7' center='3 -1 2' scale='.5 .5 .5'");
  written("", "rotation='0 0 1 1' scale='1 2 3' scaleOrientation='1 1 0 0.5' center='1 0 0'");
  written("", "scale='-1 2 -3'");
  written(
      "<head><unit category='length' name='inch' conversionFactor='0.0254'/><unit "
      "category='angle' name='degree' conversionFactor='0.0174532925'/></head>",
      "translation='10 20 30' rotation='0 1 0 90'");
  EXPECT_EQ(written("", "scale='1 0 1'"), "a Viewpoint in a flat Transform");
  EXPECT_EQ(written("", "scale='1 -1 1'"),
            "a Viewpoint in a Transform that mirrors, as its picture would be");
  EXPECT_EQ(written("", "translation='1 2'"),
            "a Transform around the Viewpoint that cannot be read");
}

TEST(StudioEdit, WritesAViewpointIntoAnEmptyScene) {
  const CameraPose pose{{1, 2, 3}, {1, 2, 0}, {0, 1, 0}, 45.0, "smaller", {}};
  const Outline made = x3d_text("<X3D version='4.0'><Scene/></X3D>");
  EXPECT_EQ(applied(made, write_camera(made, "", pose)),
            "<X3D version='4.0'><Scene><Viewpoint position='1 2 3' "
            "fieldOfView='0.78539816'/></Scene></X3D>");
}

TEST(StudioEdit, WritesAViewpointInsideOfTransformsOfAClassicText) {
  const CameraPose pose{{1, 2, 3}, {0, 0.5, 0.25}, {.1, 1, 0}, 40.0, "smaller", {}};
  const Outline made = outline(
      Language::classic_x3d,
      "#X3D V3.3 utf8\nTransform { rotation 0 1 0 1 children [\n  DEF T Transform {\n    "
      "translation 4 0 0 scale 2 1 1 children Viewpoint { viewAll TRUE }\n  }\n  USE T ]\n}\n");
  const std::string text = applied(made, write_camera(made, "", pose));
  expect_seen_from(pose, text, Language::classic_x3d);
  EXPECT_FALSE(parse_x3d(text, "made.x3dv", {}).scene.cameras(0).frame_all());
  EXPECT_TRUE(write_camera(outline(Language::classic_x3d, text), "", pose).edits.empty());
  const Outline prototype =
      outline(Language::classic_x3d, "#X3D V3.3 utf8\nPROTO P [] { Viewpoint { } }\nP { }\n");
  EXPECT_EQ(write_camera(prototype, "", pose).refusal->found, "a Viewpoint of a prototype");
}

TEST(StudioEdit, WritesAWindowInTheUnitOfTheDocument) {
  const Outline made = x3d_text(
      "<X3D version='3.3'><head><unit category='length' name='cm' "
      "conversionFactor='0.01'/></head><Scene><OrthoViewpoint/></Scene></X3D>");
  const CameraPose pose{{1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, {}, "", 5};
  const std::string text = applied(made, write_camera(made, "", pose));
  EXPECT_NE(text.find("fieldOfView='-250 -250 250 250'"), std::string::npos) << text;
  EXPECT_NE(text.find("position='100 200 300'"), std::string::npos) << text;
  const v1::Orthographic window = parse_x3d(text, "made.x3d", {}).scene.cameras(0).orthographic();
  EXPECT_NEAR(window.max_y() - window.min_y(), 5, 1e-5);
  const Outline scaled = x3d_text(
      "<X3D version='3.3'><Scene><Transform scale='2 2 2'><OrthoViewpoint/></Transform></Scene>"
      "</X3D>");
  EXPECT_NE(
      applied(scaled, write_camera(scaled, "", pose)).find("fieldOfView='-1.25 -1.25 1.25 1.25'"),
      std::string::npos);
}

TEST(StudioEdit, FindsAViewpointByTheNameThatTheReaderGivesIt) {
  const Outline made = x3d_text(
      "<X3D version='4.0'><Scene><Viewpoint DEF='a' description='b'/><Viewpoint description='c'/>"
      "</Scene></X3D>");
  const CameraPose pose{{1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, {}, "", {}};
  const std::string text = applied(made, write_camera(made, "c", pose));
  EXPECT_NE(text.find("<Viewpoint description='c' position='1 2 3'"), std::string::npos) << text;
  EXPECT_FALSE(write_camera(made, "b", pose).is_made());
}

TEST(StudioEdit, PlacesAndLimitsInTheUnitsOfTheDocument) {
  const std::string head =
      "<X3D version='3.3'><head><unit category='length' name='inch' "
      "conversionFactor='0.5'/><unit category='angle' name='degree' "
      "conversionFactor='0.0174532925'/></head><Scene><Viewpoint fieldOfView='36'/></Scene></X3D>";
  const Outline made = x3d_text(head);
  const int viewpoint = 4;
  EXPECT_NE(applied(made, set_field(made, viewpoint, "fieldOfView", "40")).find("'40'"),
            std::string::npos);
  for (const Field& field : all_fields(made, viewpoint)) {
    EXPECT_NE(field.unit, "m") << field.name;
    EXPECT_NE(field.unit, "rad") << field.name;
  }
  const std::string placed = applied(made, add_include(made, "a.x3d", {{1, 2, 3}}));
  EXPECT_NE(placed.find("'2 4 6'"), std::string::npos) << placed;
}

RC_GTEST_PROP(SourceMap, RangesOfDamagedX3dNest, ()) {
  const auto all = samples(".x3d");
  std::string text = all[*rc::gen::inRange<size_t>(0, all.size())].text;
  const auto hits =
      *rc::gen::resize(6, rc::gen::container<std::vector<std::pair<size_t, int>>>(rc::gen::pair(
                              rc::gen::inRange<size_t>(0, 1 << 20), rc::gen::inRange(0, 100))));
  for (const auto& [at, c] : hits) {
    if (text.empty()) break;
    constexpr std::string_view kBytes = "<>/='\"!-?[]& \na0\xC3";
    if (c % 3 == 0) {
      text.resize(at % text.size());
    } else if (c % 3 == 1) {
      text.erase(at % text.size(), 1 + at % 5);
    } else {
      text.insert(at % text.size(), 1, kBytes[at / 7 % kBytes.size()]);
    }
  }
  const Outline outline = x3d_text(text);
  expect_nested(outline);
  const auto entity = static_cast<int>(*rc::gen::inRange<size_t>(0, outline.entities().size()));
  for (const Field& field : all_fields(outline, entity)) {
    const Change change = set_field(outline, entity, field.name, "3");
    if (change.is_made()) expect_nested(x3d_text(apply_edits(text, change.edits)));
  }
  const Change camera = write_camera(outline, "", {{1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 40.0, "", {}});
  if (camera.is_made()) expect_nested(x3d_text(apply_edits(text, camera.edits)));
}

TEST(SourceMap, DeepTextsEndSomewhere) {
  for (const char* const part :
       {"<a>", "<a b='", "{ ", "nodes { ", "nodes: [ ", "[", "{\"nodes\":["}) {
    std::string text;
    for (int i = 0; i < 50'000; ++i) text += part;
    for (const Language language : {Language::x3d, Language::tessera, Language::json})
      expect_nested(outline(language, text));
  }
}

}  // namespace
}  // namespace tessera::edit
