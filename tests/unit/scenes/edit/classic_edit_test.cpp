#include <gtest/gtest.h>

#include "scenes/formats/x3d/x3d_reader.h"
#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

Outline classic_text(const std::string& text) { return outline(Language::classic_x3d, text); }

TEST(StudioEdit, SetsTheNumbersOfEveryClassicSample) {
  for (const SampleText& sample : samples(".x3dv")) {
    SCOPED_TRACE(sample.name);
    const Outline outline = classic_text(sample.text);
    expect_nested(outline);
    size_t count = 0;
    for (size_t i = 0; i < outline.entities().size(); ++i) {
      for (const Field& field : outline.entities()[i].fields) {
        const bool is_vector = field.kind == ValueKind::vector || field.kind == ValueKind::color;
        if ((field.kind != ValueKind::number && !is_vector) || !field.locked.empty()) continue;
        if (field.name == "outerRadius") continue;  // has to be more than its innerRadius
        SCOPED_TRACE(outline.entities()[i].path + " " + field.name + " = " + field.text);
        const Change change =
            set_field(outline, static_cast<int>(i), field.name, is_vector ? "0.5 .25 0.75" : "0.5");
        ASSERT_TRUE(change.is_made()) << refusal_of(change);
        for (const TextEdit& edit : change.edits) ASSERT_TRUE(field.value.contains(edit.range));
        const std::string made = apply_edits(outline.text(), change.edits);
        ASSERT_EQ(apply_edits(made, inverse_edits(outline.text(), change.edits)), outline.text());
        EXPECT_NO_THROW(parse_x3d(made, "made.x3dv", {}));
        ++count;
      }
    }
    EXPECT_GT(count, 20u);
    for (size_t i = 1; i < outline.entities().size(); ++i) {
      for (const Change& change :
           {remove(outline, static_cast<int>(i)), duplicate(outline, static_cast<int>(i))})
        if (change.is_made())
          expect_nested(classic_text(apply_edits(outline.text(), change.edits)));
    }
    for (const EntityTemplate& added : entity_templates(Language::classic_x3d))
      EXPECT_NO_THROW(parse_x3d(applied(outline, add(outline, 0, added)), "made.x3dv", {}))
          << added.name;
    const CameraPose pose{{1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, 40.0, "", {}};
    const Change camera = write_camera(outline, "", pose);
    if (camera.is_made()) {
      const std::string made = apply_edits(outline.text(), camera.edits);
      EXPECT_NO_THROW(parse_x3d(made, "made.x3dv", {}));
      EXPECT_TRUE(write_camera(classic_text(made), "", pose).edits.empty());
    }
  }
}

TEST(StudioEdit, InsertsClassicFields) {
  const std::string text = "#VRML V2.0 utf8\nShape {\n  geometry DEF s Sphere { }\n}\n";
  const Outline made = classic_text(text);
  const int sphere = made.entity_named(EntityKind::shape, "s").value();
  EXPECT_EQ(applied(made, set_field(made, sphere, "radius", "2")),
            "#VRML V2.0 utf8\nShape {\n  geometry DEF s Sphere { radius 2 }\n}\n");
  EXPECT_EQ(applied(made, remove(made, sphere)), "#VRML V2.0 utf8\nShape {\n}\n");
}

TEST(SourceMap, RangesOfCutClassicTextsNest) {
  for (const SampleText& sample : samples(".x3dv"))
    for (size_t size = 0; size < sample.text.size(); size += 37)
      expect_nested(classic_text(sample.text.substr(0, size)));
  for (const char* const part :
       {"Group { children [ ", "DEF a ", "a [ ", "} ", "Shape { geometry "}) {
    std::string text;
    for (int i = 0; i < 20'000; ++i) text += part;
    expect_nested(classic_text(text));
  }
}

}  // namespace
}  // namespace tessera::edit
