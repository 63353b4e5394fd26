#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "scenes/edit/crt_edit.h"
#include "scenes/edit/crt_words.h"
#include "scenes/formats/crt/crt_objects.h"
#include "scenes/formats/crt/crt_reader.h"
#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

Outline crt_text(const std::string& text) { return outline(Language::crt, text); }

int entity_named(const Outline& outline, std::string_view name) {
  for (size_t i = 0; i < outline.entities().size(); ++i)
    if (outline.entities()[i].name == name || outline.entities()[i].type == name)
      return static_cast<int>(i);
  ADD_FAILURE() << "no entity " << name;
  return 0;
}

std::string set(const std::string& text, std::string_view entity, std::string_view field,
                std::string_view value) {
  const Outline made = crt_text(text);
  return applied(made, set_field(made, entity_named(made, entity), field, value));
}

LoadedScene read(const std::string& text) { return parse_crt(text, "made.crt", {}, 0); }

/// A value that the field may have and does not.
std::string other_value(const Field& field) {
  switch (field.kind) {
    case ValueKind::vector:
    case ValueKind::color:
      return ".25 7 0.75";
    case ValueKind::boolean:
      return field.text == "true" ? "false" : "true";
    case ValueKind::choice:
      return field.text == field.choices[0] ? field.choices[1] : field.choices[0];
    case ValueKind::text:
    case ValueKind::file:
      return "a \"b\"";
    case ValueKind::integer:
      return field.text == "2" ? "3" : "2";
    default:
      return field.text == "0.75" ? "0.5" : "0.75";
  }
}

TEST(StudioEdit, SetsEveryLiteralOfEveryCrtSample) {
  for (const SampleText& sample : samples(".crt")) {
    SCOPED_TRACE(sample.name);
    const Outline outline = crt_text(sample.text);
    expect_nested(outline);
    size_t count = 0;
    for (size_t i = 0; i < outline.entities().size(); ++i) {
      for (const Field& field : outline.entities()[i].fields) {
        if (!field.locked.empty() || field.kind == ValueKind::reference) continue;
        SCOPED_TRACE(outline.entities()[i].path + " " + field.name + " = " + field.text);
        const std::string value = other_value(field);
        const Change change = set_field(outline, static_cast<int>(i), field.name, value);
        if (!change.is_made()) {  // a part of a vector that is computed
          EXPECT_TRUE(change.refusal->found.starts_with("computed") ||
                      change.refusal->found.starts_with("one variable"))
              << change.refusal->found;
          continue;
        }
        ASSERT_FALSE(change.edits.empty());
        const std::string made = apply_edits(outline.text(), change.edits);
        ASSERT_EQ(apply_edits(made, inverse_edits(outline.text(), change.edits)), outline.text());
        const Outline again = crt_text(made);
        ASSERT_EQ(again.entities().size(), outline.entities().size());
        // The number that a float gets is a float, so that values are compared, not words.
        bool is_there = false;
        for (const Field& now : again.entities()[i].fields) {
          if (now.name != field.name) continue;
          is_there = true;
          const bool is_same = now.text == value || now.text == value + ".0" ||
                               now.text.find("7") != std::string::npos;
          EXPECT_TRUE(is_same) << now.text;
        }
        EXPECT_TRUE(is_there);
        ++count;
      }
    }
    EXPECT_GT(count, 20u);
  }
}

TEST(StudioEdit, TheCrtReaderReadsWhatWasSet) {
  const std::string text = R"(-- two balls
m = Material { color -> rgb(0.5, 0.5, 0.5) }
size = 0.5
cam = Camera { position -> vec3(0, 1, -5)  pointing -> vec3(0, 0, 0)  fov -> 50 }
Settings { camera -> cam lights -> [] }
Scene {
    Sphere { center -> vec3(0, 0, 0)  radius -> size  material -> m }
    Sphere { center -> vec3(2.0, 0, 0)  radius -> size * 2  material -> m } <translate vec3(1, 0, 0)>
}
)";
  const auto radius = [](const std::string& script, int node) {
    return read(script).scene.nodes(node).shape().sphere().radius();
  };
  EXPECT_EQ(radius(text, 0), .5);
  const Outline outline = crt_text(text);
  const int first = entity_named(outline, "Sphere");
  const Change shared = set_field(outline, first, "radius", "2");
  EXPECT_EQ(shared.changed, 2) << "both spheres depend on it";
  EXPECT_NE(applied(outline, shared).find("size = 2.0\n"), std::string::npos);
  EXPECT_EQ(radius(applied(outline, shared), 0), 2);
  const int second = outline.entity_of_path("Scene[0].Sphere[1]").value();
  EXPECT_EQ(refusal_of(set_field(outline, second, "radius", "1")), "size * 2; computed: size * 2");
  EXPECT_NE(set(text, "Sphere", "center", "1 0 3").find("center -> vec3(1, 0, 3)"),
            std::string::npos);
  const std::string moved = applied(outline, set_field(outline, second, "center", "3 0 0"));
  EXPECT_NE(moved.find("vec3(3.0, 0, 0)"), std::string::npos) << "a float stays a float";
  EXPECT_NE(set(text, "translate", "value", "1 5 0").find("<translate vec3(1, 5, 0)>"),
            std::string::npos);
  EXPECT_EQ(crt_number("2", "2.0"), "2.0");
  EXPECT_EQ(crt_number("1e-3", "2"), "0.001");
  EXPECT_EQ(crt_number("+.5", "2"), "0.5");
}

TEST(StudioEdit, InsertsCrtAttributesWithAlignedArrows) {
  const std::string text =
      "cam = Camera {\n    position -> vec3(0, 1, -5)\n    fov      -> 50\n}\n";
  EXPECT_EQ(set(text, "Camera", "pointing", "0 0 1"),
            "cam = Camera {\n    position -> vec3(0, 1, -5)\n    pointing -> vec3(0, 0, 1)\n"
            "    fov      -> 50\n}\n");
  EXPECT_EQ(
      set(text, "Camera", "aperture", "4"),
      "cam = Camera {\n    position -> vec3(0, 1, -5)\n    fov      -> 50\n    aperture -> 4\n}\n");
  EXPECT_EQ(set("Sphere { radius -> 1 }", "Sphere", "center", "1 2 3"),
            "Sphere { center -> vec3(1, 2, 3) radius -> 1 }");
  const Outline made = crt_text(text);
  EXPECT_NE(refusal_of(set_field(made, 1, "fow", "4")).find("did you mean 'fov'"),
            std::string::npos);
  for (const char* const wrong : {"nan", "", "1,5", "400", "-1"})
    EXPECT_FALSE(set_field(made, 1, "fov", wrong).is_made()) << wrong;
}

TEST(StudioEdit, PlacesWhatItAddsToAScript) {
  const Outline made = crt_text("Scene {\n    Sphere { radius -> 1 }\n}\n");
  EntityTemplate sphere{"sphere", "Sphere", {{"radius", "2"}}, {{1.5, 0, -.25}}};
  EXPECT_NE(applied(made, add(made, 0, sphere)).find("} <translate vec3(1.5, 0, -0.25)>"),
            std::string::npos);
  EXPECT_NE(applied(made, add_include(made, "a.obj", {{1, 2, 3}}))
                .find("Mesh { file -> \"a.obj\" } <translate vec3(1, 2, 3)>"),
            std::string::npos);
  EXPECT_TRUE(add(made, 0, {"m", "Material", {{"color", "1 1 1"}}, {{0, 1, 0}}}).refusal);
}

TEST(StudioEdit, AddsAndRemovesInEveryCrtSample) {
  for (const SampleText& sample : samples(".crt")) {
    const Outline outline = crt_text(sample.text);
    const int before = read(sample.text).scene.nodes_size();
    for (const EntityTemplate& added : entity_templates(Language::crt)) {
      if (added.type == "Mesh") continue;
      SCOPED_TRACE(sample.name + " " + added.name);
      const std::string made = applied(outline, add(outline, 0, added));
      const LoadedScene loaded = read(made);
      EXPECT_EQ(loaded.scene.nodes_size() > before, added.type != "Material");
    }
    for (size_t i = 1; i < outline.entities().size(); ++i) {
      const Change removed = remove(outline, static_cast<int>(i));
      if (removed.is_made()) expect_nested(crt_text(applied(outline, removed)));
      const Change doubled = duplicate(outline, static_cast<int>(i));
      if (!doubled.is_made()) continue;
      const Outline again = crt_text(applied(outline, doubled));
      EXPECT_GT(again.entities().size(), outline.entities().size());
    }
  }
}

TEST(StudioEdit, RemovesFromCrtWithoutTrace) {
  const auto without = [](const std::string& text, const std::string& path) {
    const Outline made = crt_text(text);
    return applied(made, remove(made, made.entity_of_path(path).value()));
  };
  EXPECT_EQ(without("Scene {\n    Sphere { }\n    Box { }\n}\n", "Scene[0].Sphere[0]"),
            "Scene {\n    Box { }\n}\n");
  EXPECT_EQ(without("Scene { a <scale 2, rotate vec3(0, 1, 0)> }", "Scene[0].a[0].scale[0]"),
            "Scene { a <rotate vec3(0, 1, 0)> }");
  EXPECT_EQ(without("Scene { a <scale 2> }", "Scene[0].a[0].scale[0]"), "Scene { a }");
  const Outline used = crt_text("m = Material { }\nScene { Sphere { material -> m } }");
  EXPECT_EQ(refusal_of(remove(used, 1)), "'m' is used 1 times; what is not used");
}

TEST(StudioEdit, WritesTheCameraOfEveryCrtSample) {
  for (const SampleText& sample : samples(".crt")) {
    CameraPose pose{{1.23456789, 2, -7.5}, {1.0 / 3, .5, 0}, {0, 1, 0}, 41.25, "", {}};
    // As the view tells it of a panorama, which has none.
    if (!read(sample.text).scene.cameras(0).has_perspective()) pose.axis = "smaller";
    const Outline outline = crt_text(sample.text);
    const std::string made = applied(outline, write_camera(outline, "", pose));
    const v1::Camera camera = read(made).scene.cameras(0),
                     before = read(sample.text).scene.cameras(0);
    EXPECT_EQ(camera.perspective().field_of_view(), camera.has_perspective() ? 41.25 : 0);
    // A panorama keeps its angle.
    EXPECT_EQ(camera.spherical().field_of_view(), before.spherical().field_of_view());
    EXPECT_EQ(camera.cylindrical().field_of_view(), before.cylindrical().field_of_view());
    for (int row = 0; row < 3; ++row)
      EXPECT_NEAR(camera.world_from_camera().steps(0).matrix().rows(row * 4 + 3),
                  pose.eye[static_cast<size_t>(row)], 1e-6);
    EXPECT_TRUE(write_camera(crt_text(made), "", pose).edits.empty());
  }
}

TEST(StudioEdit, WritesACameraIntoAScriptWithoutOne) {
  CameraPose pose{{1, 2, -7.5}, {0, .5, 0}, {0, 1, 0}, 41.25, "vertical", {}};
  const auto written = [&](const std::string& text) {
    const Outline made = crt_text(text);
    const Change change = write_camera(made, "gone", pose);
    if (change.refusal) return change.refusal->found;
    const std::string changed = applied(made, change);
    const v1::Camera camera = read(changed).scene.cameras(0);
    EXPECT_EQ(camera.perspective().field_of_view(), 41.25);
    EXPECT_EQ(camera.world_from_camera().steps(0).matrix().rows(11), -7.5);
    EXPECT_TRUE(write_camera(crt_text(changed), "", pose).edits.empty());
    return changed;
  };
  const std::string camera =
      "Camera { position -> vec3(1, 2, -7.5) pointing -> vec3(0, 0.5, 0) fov -> 41.25 }";
  EXPECT_EQ(
      written("-- a\nSettings {\n    title -> \"T\"\n    lights -> []\n}\nScene { }\n"),
      "-- a\ncam = " + camera +
          "\nSettings {\n    title -> \"T\"\n    camera -> cam\n    lights -> []\n}\nScene { }\n");
  EXPECT_EQ(written("Settings { lights -> [] camera -> eye } Scene { }"),
            "eye = " + camera + "\nSettings { lights -> [] camera -> eye } Scene { }")
      << "the name that is there for it";
  EXPECT_EQ(written("cam = 2 Settings { } Scene { }"),
            "cam = 2 cam2 = " + camera + " Settings { camera -> cam2 } Scene { }");
  EXPECT_EQ(
      written("Settings {\n    width  -> 96\n    height -> 54\n}\nScene { }"),
      "cam = " + camera +
          "\nSettings {\n    width  -> 96\n    height -> 54\n    camera -> cam\n}\nScene { }");
  EXPECT_EQ(written("Scene { }"), "a script without Settings");
  EXPECT_EQ(written("a = 2 Settings { camera -> a } Scene { }"), "a");
  pose.axis = "smaller";
  EXPECT_EQ(written("Settings { } Scene { }"), "a field of view over the smaller axis");
  const Outline two = crt_text("a = Camera { } Settings { camera -> a } Scene { }");
  EXPECT_EQ(write_camera(two, "b", pose).refusal->found, "no Camera 'b'");
}

TEST(StudioEdit, KnowsTheObjectsOfTheCrtReader) {
  const auto names = crt_object_names();
  EXPECT_EQ(crt_words().size(), names.size() + 1) << "Settings is one of ours";
  for (const std::string& name : names) EXPECT_NE(find_crt_word(name), nullptr) << name;
}

RC_GTEST_PROP(SourceMap, RangesOfDamagedCrtNest, ()) {
  const auto all = samples(".crt");
  std::string text = all[*rc::gen::inRange<size_t>(0, all.size())].text;
  const auto hits =
      *rc::gen::resize(6, rc::gen::container<std::vector<std::pair<size_t, int>>>(rc::gen::pair(
                              rc::gen::inRange<size_t>(0, 1 << 20), rc::gen::inRange(0, 100))));
  for (const auto& [at, c] : hits) {
    if (text.empty()) break;
    constexpr std::string_view kBytes = "{}[]()<>=,;\"-.0aA\n\\+/\xC3";
    if (c % 3 == 0)
      text.resize(at % text.size());
    else if (c % 3 == 1)
      text.erase(at % text.size(), 1 + at % 5);
    else
      text.insert(at % text.size(), 1, kBytes[at / 7 % kBytes.size()]);
  }
  const Outline outline = crt_text(text);
  expect_nested(outline);
  const auto entity = static_cast<int>(*rc::gen::inRange<size_t>(0, outline.entities().size()));
  for (const Field& field : all_fields(outline, entity)) {
    const Change change = set_field(outline, entity, field.name, "3");
    if (change.is_made()) expect_nested(crt_text(apply_edits(text, change.edits)));
  }
  (void)remove(outline, entity);
  (void)duplicate(outline, entity);
  const Change camera = write_camera(outline, "", {{1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 40.0, "", {}});
  if (camera.is_made()) expect_nested(crt_text(apply_edits(text, camera.edits)));
}

TEST(SourceMap, DeepCrtEndsSomewhere) {
  for (const char* const part :
       {"(", "[", "f(", "Union {", "-", "a[", "a<scale 1>[0]", "Macro(x) {",
        "m -> Material { color -> ", "1 + ", "a = ", "if (x) {"}) {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += part;
    SCOPED_TRACE(part);
    expect_nested(crt_text(text));
    expect_nested(crt_text("Scene { " + text + " }"));
  }
}

TEST(StudioEdit, AChangeOfATextWithMistakesThatLosesItsCameraIsRefused) {
  const Change change =
      write_camera(crt_text("(Camera"), "", {{1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 40.0, "", {}});
  ASSERT_TRUE(change.refusal);
  EXPECT_EQ(change.refusal->found, "a text with mistakes");
}

}  // namespace
}  // namespace tessera::edit
