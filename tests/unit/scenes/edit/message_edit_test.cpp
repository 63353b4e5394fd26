#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/vocabulary.h"
#include "scenes/import/to_affine.h"
#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

Outline tessera_text(const std::string& text) { return outline(Language::tessera, text); }
Outline json_text(const std::string& text) { return outline(Language::json, text); }

std::string set(const std::string& text, const std::string& path, std::string_view field,
                std::string_view value) {
  const Outline made = text.starts_with('{') ? json_text(text) : tessera_text(text);
  const int entity = path.empty() ? 0 : made.entity_of_path(path).value();
  return applied(made, set_field(made, entity, field, value));
}

std::string refused(const std::string& text, const std::string& path, std::string_view field,
                    std::string_view value) {
  const Outline made = tessera_text(text);
  return refusal_of(
      set_field(made, path.empty() ? 0 : made.entity_of_path(path).value(), field, value));
}

TEST(StudioEdit, InsertsBesideSiblingsInTheirStyle) {
  EXPECT_EQ(set("settings { width: 4 height: 5 }", "settings", "sampling.seed", "3"),
            "settings { width: 4 height: 5 sampling { seed: 3 } }");
  EXPECT_EQ(set("settings { height: 5 }", "settings", "width", "4"),
            "settings { width: 4 height: 5 }");
  EXPECT_EQ(set("settings {\r\n\twidth: 4  # pixels\r\n}\r\n", "settings", "height", "5"),
            "settings {\r\n\twidth: 4  # pixels\r\n\theight: 5\r\n}\r\n");
  EXPECT_EQ(set("settings {\n  height: 4\n}\n", "settings", "width", "5"),
            "settings {\n  width: 5\n  height: 4\n}\n");
  EXPECT_EQ(set("settings { width: 4, height: 5 }", "settings", "time", "1"),
            "settings { width: 4, height: 5 time: 1 }");
  EXPECT_EQ(set("settings { width: 4, height: 5, }", "settings", "time", "1"),
            "settings { width: 4, height: 5, time: 1, }");
  EXPECT_EQ(set("settings {}", "settings", "width", "5"), "settings { width: 5 }");
  EXPECT_EQ(set("  settings {\n  }\n", "settings", "width", "5"),
            "  settings {\n    width: 5\n  }\n");
  EXPECT_EQ(set("nodes { }", "", "settings.width", "5"), "settings { width: 5 }\nnodes { }");
  EXPECT_EQ(set("\xEF\xBB\xBF# nothing", "", "settings.width", "5"),
            "\xEF\xBB\xBF# nothing\nsettings { width: 5 }\n");
}

TEST(StudioEdit, InsertsIntoJson) {
  EXPECT_EQ(set(R"({"settings": {"width": 4}})", "settings", "height", "5"),
            R"({"settings": {"width": 4, "height": 5}})");
  EXPECT_EQ(set(R"({"settings":{"height":4}})", "settings", "width", "+05"),
            R"({"settings":{"width":5,"height":4}})");
  EXPECT_EQ(set("{\n \"fog\": {\n  \"kind\": \"LINEAR\"\n }\n}\n", "fog", "visibility_range", ".5"),
            "{\n \"fog\": {\n  \"kind\": \"LINEAR\",\n  \"visibilityRange\": 0.5\n }\n}\n");
}

TEST(StudioEdit, SetsPartsOfVectors) {
  const std::string text = "nodes { shape { sphere { center { x: 1 z: 3 } } } }";
  EXPECT_EQ(set(text, "nodes[0].shape", "sphere.center", "1 0 3"), text);
  EXPECT_EQ(set(text, "nodes[0].shape", "sphere.center", "1 2 3"),
            "nodes { shape { sphere { center { x: 1 y: 2 z: 3 } } } }");
  EXPECT_EQ(set(text, "nodes[0].shape", "sphere.center", "1, 0, .5"),
            "nodes { shape { sphere { center { x: 1 z: .5 } } } }");
  EXPECT_EQ(set("nodes { shape { sphere { } } }", "nodes[0].shape", "sphere.center", "1 2 3"),
            "nodes { shape { sphere { center { x: 1 y: 2 z: 3 } } } }");
  EXPECT_EQ(set("materials { classic { } }", "materials[0]", "classic.diffuse", "1 0 .5"),
            "materials { classic { diffuse { value { r: 1 b: .5 } } } }");
}

TEST(StudioEdit, RefusesWhatIsNoValue) {
  const std::string text = "cameras { perspective { field_of_view: 40 } } settings { width: 4 }";
  for (const char* const wrong :
       {"nan", "inf", "-inf", "", " ", "1,5", "1;2", "0x10", "1e999", "--1"})
    EXPECT_NE(refused(text, "cameras[0]", "perspective.field_of_view", wrong), "none") << wrong;
  EXPECT_EQ(refused(text, "cameras[0]", "perspective.field_of_view", "180"),
            "'180'; a number such as 1.5, above 0 and below 180");
  EXPECT_EQ(refused(text, "settings", "width", "65537"),
            "'65537'; an integer, at least 1 and at most 65536");
  EXPECT_EQ(refused(text, "settings", "width", "1.5"),
            "'1.5'; an integer, at least 1 and at most 65536");
  EXPECT_EQ(refused(text, "settings", "sampling.filter", "TEMT"),
            "'TEMT'; one of BOX, TENT, GAUSSIAN, MITCHELL, BLACKMAN_HARRIS; did you mean 'TENT'?");
  EXPECT_NE(refused(text, "cameras[0]", "orthographic.min_x", "1"), "none");
  EXPECT_NE(refused(text, "settings", "heigt", "1"), "none");
}

TEST(StudioEdit, TellsDefaultsUnitsAndRanges) {
  const Outline made = tessera_text("cameras { }");
  bool has_angle = false;
  for (const Field& field : all_fields(made, 1)) has_angle |= field.name.starts_with("perspective");
  EXPECT_FALSE(has_angle) << "a member of a oneof that is not chosen";
  const Outline chosen = tessera_text("cameras { perspective { } }");
  for (const Field& field : all_fields(chosen, 1)) {
    if (field.name != "perspective.field_of_view") continue;
    has_angle = true;
    EXPECT_EQ(field.fallback, "45");
    EXPECT_EQ(field.unit, "deg");
    EXPECT_EQ(field.limits.str(), "above 0 and below 180");
    EXPECT_FALSE(field.is_present);
  }
  EXPECT_TRUE(has_angle);
}

TEST(StudioEdit, RemovesWithoutTrace) {
  const auto without = [](const std::string& text, const std::string& path) {
    const Outline made = text.starts_with('{') ? json_text(text) : tessera_text(text);
    return applied(made, remove(made, made.entity_of_path(path).value()));
  };
  EXPECT_EQ(without("nodes { }\nnodes { name: 'b' }\nfog { }\n", "nodes[1]"),
            "nodes { }\nfog { }\n");
  EXPECT_EQ(without("nodes { } nodes { name: 'b' } fog { }", "nodes[1]"), "nodes { } fog { }");
  EXPECT_EQ(without("nodes: [{ }, { name: 'b' }]", "nodes[1]"), "nodes: [{ }]");
  EXPECT_EQ(without("nodes: [{ name: 'a' }, { }]", "nodes[0]"), "nodes: [{ }]");
  EXPECT_EQ(without(R"({"nodes": [{}, {"name": "b"}], "fog": {}})", "nodes[1]"),
            R"({"nodes": [{}], "fog": {}})");
  EXPECT_EQ(without(R"({"nodes": [{}], "fog": {}})", "fog"), R"({"nodes": [{}]})");
  EXPECT_EQ(without(R"({"fog": {}, "nodes": [{}]})", "fog"), R"({"nodes": [{}]})");
}

TEST(StudioEdit, DuplicatesUnderAFreeName) {
  const Outline made =
      tessera_text("materials { name: \"red\" }  # warm\nmaterials { name: \"red 2\" }\n");
  EXPECT_EQ(applied(made, duplicate(made, 1)),
            "materials { name: \"red\" }  # warm\nmaterials { name: \"red 3\" }\n"
            "materials { name: \"red 2\" }\n");
  const Outline json = json_text(R"({"materials": [{"name": "red"}]})");
  EXPECT_EQ(applied(json, duplicate(json, 1)),
            R"({"materials": [{"name": "red"}, {"name": "red 2"}]})");
}

TEST(StudioEdit, AddsEveryTemplateToEverySample) {
  for (const SampleText& sample : samples(".tessera")) {
    const SceneWithBlobs read = decode_scene(sample.text, SceneEncoding::text, "sample");
    const std::string json = encode_scene(read.scene, read.blobs, SceneEncoding::json);
    for (const EntityTemplate& added : entity_templates(Language::tessera)) {
      SCOPED_TRACE(sample.name + " " + added.name);
      const Outline text = tessera_text(sample.text);
      const Outline other = json_text(json);
      const int parent =
          added.type.starts_with("transform") ? text.entity_of_path("nodes[0]").value() : 0;
      const int holder =
          added.type.starts_with("transform") ? other.entity_of_path("nodes[0]").value() : 0;
      const std::string made = applied(text, add(text, parent, added));
      const std::string made_json = applied(other, add(other, holder, added));
      const auto a = decode_scene(made, SceneEncoding::text, "made");
      const auto b = decode_scene(made_json, SceneEncoding::json, "made");
      EXPECT_EQ(serialize_scene(a.scene), serialize_scene(b.scene));
      EXPECT_NE(serialize_scene(a.scene), serialize_scene(read.scene));
    }
  }
}

TEST(StudioEdit, AddsAnInclude) {
  const Outline made = tessera_text("nodes { }\nincludes { file: 'a.obj' }\n");
  EXPECT_EQ(applied(made, add_include(made, "b.obj")),
            "nodes { }\nincludes { file: 'a.obj' }\nincludes { file: \"b.obj\" }\n");
  const Outline json = json_text("{}");
  EXPECT_EQ(applied(json, add_include(json, "b.obj")), R"({"includes": [{"file": "b.obj"}]})");
}

TEST(StudioEdit, PlacesWhatItAdds) {
  const Outline made = tessera_text("nodes { }\n");
  EXPECT_EQ(
      applied(made, add_include(made, "b.obj", {{1.50004, 0, -2}})),
      "nodes { }\nincludes { file: \"b.obj\" transform { steps { translate { x: 1.5 z: -2 } } } "
      "}\n");
  EntityTemplate sphere{"sphere", "nodes", {{"shape.sphere.radius", "1"}}, {{0, .25, 0}}};
  EXPECT_EQ(
      applied(made, add(made, 0, sphere)),
      "nodes { }\nnodes { shape { sphere { radius: 1 } } transform { steps { translate { y: 0.25 "
      "} } } }\n");
  EXPECT_TRUE(add(made, 0, {"m", "materials", {{"name", "m"}}, {{0, 1, 0}}}).refusal);
}

TEST(StudioEdit, MakesAPictureTheBackground) {
  const Outline none = tessera_text("nodes { }\n");
  EXPECT_EQ(applied(none, set_panorama(none, "sky.hdr")),
            "background { panorama { texture: \"panorama\" } }\n"
            "textures { name: \"panorama\" image { file: \"sky.hdr\" } }\nnodes { }\n");
  const Outline solid = tessera_text(
      "background { solid { r: 1 } glow: 1 }\ntextures { name: 'panorama' noise { } }\n");
  EXPECT_EQ(applied(solid, set_panorama(solid, "sky.hdr")),
            "background { panorama { texture: \"panorama 2\" } glow: 1 }\n"
            "textures { name: 'panorama' noise { } }\n"
            "textures { name: \"panorama 2\" image { file: \"sky.hdr\" } }\n");
}

CameraPose pose_of(const std::vector<int>& numbers) {
  CameraPose pose;
  for (size_t i = 0; i < 3; ++i) {
    pose.eye[i] = numbers[i] / 977.0;
    pose.target[i] = pose.eye[i] + numbers[i + 3] / 1013.0;
    pose.up[i] = numbers[i + 6] / 300.0;
  }
  pose.field_of_view = 20 + std::abs(numbers[0] % 1000) / 7.7;
  return pose;
}

RC_GTEST_PROP(StudioEdit, WritesTheCameraOfEverySample, ()) {
  const auto numbers = *rc::gen::container<std::vector<int>>(9, rc::gen::inRange(-4000, 4000));
  const CameraPose pose = pose_of(numbers);
  const Vec3 view{pose.target[0] - pose.eye[0], pose.target[1] - pose.eye[1],
                  pose.target[2] - pose.eye[2]};
  const Vec3 up{pose.up[0], pose.up[1], pose.up[2]};
  RC_PRE(length(cross(view, up)) > .01 * length(view) * length(up) && length(view) > .01);
  const bool is_json = *rc::gen::arbitrary<bool>();
  const SceneEncoding encoding = is_json ? SceneEncoding::json : SceneEncoding::text;
  for (const SampleText& sample : samples(".tessera")) {
    constexpr size_t kShort = 20'000;
    std::string text = sample.text;
    if (text.size() > kShort) continue;
    if (is_json) {
      const SceneWithBlobs read = decode_scene(text, SceneEncoding::text, "sample");
      text = encode_scene(read.scene, read.blobs, encoding);
    }
    const Outline made = outline(is_json ? Language::json : Language::tessera, text);
    const std::string written = applied(made, write_camera(made, "", pose));
    const v1::Camera camera = decode_scene(written, encoding, "written").scene.cameras(0);
    const Affine wanted =
        look_at(Point3{} + Vec3{pose.eye[0], pose.eye[1], pose.eye[2]},
                Point3{} + Vec3{pose.target[0], pose.target[1], pose.target[2]}, up);
    const Affine got = to_affine(camera.world_from_camera());
    const double unit = std::max(1.0, length(view));
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c)
        RC_ASSERT(std::abs(wanted.m[r][c] - got.m[r][c]) <= 1e-6 * (c == 3 ? unit : 1));
    RC_ASSERT(std::abs(camera.perspective().field_of_view() - *pose.field_of_view) < 1e-6);
    // What is there already is not written again.
    const Outline again = outline(made.language(), written);
    RC_ASSERT(write_camera(again, "", pose).edits.empty());
  }
}

TEST(StudioEdit, WritesACamera) {
  CameraPose pose{{0, 1, 5.0000000001}, {0, 1.0 / 3, 0}, {0, 1, 0}, 40.0, "", {}};
  const Outline none = tessera_text("nodes { }\n");
  EXPECT_EQ(applied(none, write_camera(none, "", pose)),
            "cameras { world_from_camera { steps { look_at { eye { y: 1 z: 5 } target { y: "
            "0.333333 } } } }"
            " perspective { field_of_view: 40 } }\nnodes { }\n");
  const Outline there = tessera_text(
      "cameras { name: 'a' world_from_camera { steps { look_at { eye { y: 1.0 z: 5.0 } target { } "
      "} } } perspective { field_of_view: 40.0 } }");
  EXPECT_EQ(
      applied(there, write_camera(there, "a", pose)),
      "cameras { name: 'a' world_from_camera { steps { look_at { eye { y: 1.0 z: 5.0 } target { "
      "y: 0.333333 } } } } perspective { field_of_view: 40.0 } }");
  EXPECT_FALSE(write_camera(there, "b", pose).is_made());
  const Outline panorama = tessera_text("cameras { spherical { } }");
  EXPECT_EQ(
      applied(panorama,
              write_camera(panorama, "", {{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 45.0, "smaller", {}})),
      "cameras { world_from_camera { steps { look_at { target { z: -1 } } } } spherical { } }");
  // One without a name is called by its number.
  const Outline two = tessera_text(there.text() + "\ncameras { }\n");
  EXPECT_EQ(applied(two, write_camera(two, "2", pose)),
            there.text() +
                "\ncameras { world_from_camera { steps { look_at { eye { y: 1 z: 5 } target { y: "
                "0.333333 } } } } perspective { field_of_view: 40 } }\n");
  EXPECT_FALSE(write_camera(two, "3", pose).is_made());
  pose.field_of_view = -1;
  EXPECT_FALSE(write_camera(there, "a", pose).is_made());
}

TEST(StudioEdit, CompletesFieldsValuesAndNames) {
  const auto labels = [](std::string text) {
    const size_t cursor = text.find('|');
    text.erase(cursor, 1);
    std::vector<std::string> found;
    for (const Completion& item : completions(tessera_text(text), cursor).items)
      found.push_back(item.label);
    return found;
  };
  EXPECT_EQ(labels("fog { kind: |"), (std::vector<std::string>{"LINEAR", "EXPONENTIAL"}));
  EXPECT_EQ(labels("fog { co| }"), (std::vector<std::string>{"kind", "color", "visibility_range"}));
  EXPECT_EQ(labels("fog { kind: LINEAR | }"),
            (std::vector<std::string>{"color", "visibility_range"}));
  EXPECT_EQ(labels("materials { name: 'a' } nodes { shape { materials: '|' } }"),
            std::vector<std::string>{"a"});
  EXPECT_EQ(labels("|").size(), 11u);
  const Outline made = tessera_text("settings { width: 4 sampling { pattern: CENTER } }");
  const auto width = hover(made, made.text().find("width"));
  ASSERT_TRUE(width);
  EXPECT_EQ(width->detail, "integer in px, at least 1 and at most 65536; default 960");
  const auto center = hover(made, made.text().find("CENTER") + 1);
  ASSERT_TRUE(center);
  EXPECT_EQ(center->help, "every sample in the pixel's centre");
}

TEST(StudioEdit, ShortensNumbers) {
  EXPECT_EQ(shortest_number(1.0 / 3, 1e-3), "0.333");
  EXPECT_EQ(shortest_number(-2.0000001, 1e-6), "-2");
  EXPECT_EQ(shortest_number(1e-9, 1e-6), "0");
  EXPECT_EQ(shortest_number(0.1, 0), "0.1");
  EXPECT_EQ(shortest_number(123456789, 1), "123456790");
  EXPECT_EQ(strict_number("+.5"), "0.5");
  EXPECT_EQ(strict_number("-007."), "-7");
}

}  // namespace
}  // namespace tessera::edit
