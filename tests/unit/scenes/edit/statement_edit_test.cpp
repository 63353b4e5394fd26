#include <gtest/gtest.h>

#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

TEST(StudioEdit, SetsEveryStatementOfEveryMtlSample) {
  for (const SampleText& sample : samples(".mtl")) {
    SCOPED_TRACE(sample.name);
    const Outline made = outline(Language::mtl, sample.text);
    expect_nested(made);
    EXPECT_GT(made.entities().size(), 1u);
    for (size_t i = 1; i < made.entities().size(); ++i) {
      for (const Field& field : made.entities()[i].fields) {
        if (!field.locked.empty()) continue;
        const std::string value = field.kind == ValueKind::color     ? "0.25 .75 0.5"
                                  : field.kind == ValueKind::integer ? "1"
                                  : field.kind == ValueKind::number  ? "0.375"
                                                                     : "other";
        if (value == field.text) continue;
        const Change change = set_field(made, static_cast<int>(i), field.name, value);
        ASSERT_TRUE(change.is_made()) << field.name << ": " << refusal_of(change);
        for (const TextEdit& edit : change.edits) EXPECT_TRUE(field.value.contains(edit.range));
        const std::string text = apply_edits(sample.text, change.edits);
        EXPECT_EQ(apply_edits(text, inverse_edits(sample.text, change.edits)), sample.text);
      }
    }
  }
}

TEST(StudioEdit, AddsAStatementBesideItsSiblings) {
  const Outline made = outline(Language::mtl, "newmtl red # warm\n  Kd 1 0 0\r\n  d 1\nnewmtl b\n");
  EXPECT_EQ(applied(made, set_field(made, 1, "Ns", "+5")),
            "newmtl red # warm\n  Kd 1 0 0\r\n  Ns 5\r\n  d 1\nnewmtl b\n");
  EXPECT_EQ(applied(made, set_field(made, 1, "Kd", "1 .5 0")),
            "newmtl red # warm\n  Kd 1 0.5 0\r\n  d 1\nnewmtl b\n");
  EXPECT_EQ(applied(made, remove(made, 2)), "newmtl red # warm\n  Kd 1 0 0\r\n  d 1\n");
  for (const char* const wrong : {"1 2", "nan 0 0", "1,5 0 0", "-1 0 0", ""})
    EXPECT_FALSE(set_field(made, 1, "Kd", wrong).is_made()) << wrong;
}

TEST(StudioEdit, AFileOfMaterialsIsNoModel) {
  const Outline obj = outline(Language::obj, "mtllib m.mtl\no ball\nusemtl red\ng top\n");
  std::vector<EntityKind> kinds;
  for (const Entity& entity : obj.entities()) kinds.push_back(entity.kind);
  EXPECT_EQ(kinds, (std::vector{EntityKind::scene, EntityKind::other, EntityKind::object,
                                EntityKind::other, EntityKind::object}));
}

TEST(StudioEdit, SetsScalarsOfGltf) {
  const std::string text =
      R"({"materials":[{"name":"a","pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1]}}],"accessors":[{"count":3}]})";
  const Outline made = outline(Language::gltf, text);
  expect_nested(made);
  const int material = made.entity_named(EntityKind::material, "a").value();
  EXPECT_EQ(
      applied(made, set_field(made, material, "pbrMetallicRoughness.baseColorFactor[1]", ".5")),
      R"({"materials":[{"name":"a","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}],"accessors":[{"count":3}]})");
  EXPECT_FALSE(set_field(made, material + 1, "count", "4").is_made());
}

}  // namespace
}  // namespace tessera::edit
