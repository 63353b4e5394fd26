#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <memory>

#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

namespace pb = google::protobuf;

TEST(SourceMap, EachTesseraEntityCutOutIsThatEntity) {
  for (const SampleText& sample : samples(".tessera")) {
    SCOPED_TRACE(sample.name);
    v1::Scene scene = decode_scene(sample.text, SceneEncoding::text, "sample").scene;
    const Outline outline = edit::outline(Language::tessera, sample.text);
    for (size_t i = 1; i < outline.entities().size(); ++i) {
      const Entity& entity = outline.entities()[i];
      if (entity.kind == EntityKind::blob) continue;
      const pb::Message& expected = *reflect(scene, entity.path).message();
      const std::unique_ptr<pb::Message> alone(expected.New());
      const std::string body(text_of(sample.text, entity.body));
      ASSERT_TRUE(pb::TextFormat::ParseFromString(body, alone.get())) << entity.path;
      ASSERT_EQ(alone->SerializeAsString(), expected.SerializeAsString()) << entity.path;
      EXPECT_EQ(outline.entity_of_path(entity.path), static_cast<int>(i));
    }
  }
}

TEST(SourceMap, EachJsonEntityCutOutIsThatEntity) {
  for (const SampleText& sample : samples(".tessera")) {
    SCOPED_TRACE(sample.name);
    SceneWithBlobs read = decode_scene(sample.text, SceneEncoding::text, "sample");
    const std::string text = encode_scene(read.scene, read.blobs, SceneEncoding::json);
    const Outline outline = edit::outline(Language::json, text);
    EXPECT_GT(outline.entities().size(), 5u);
    for (size_t i = 1; i < outline.entities().size(); ++i) {
      const Entity& entity = outline.entities()[i];
      if (entity.kind == EntityKind::blob) continue;
      const pb::Message& expected = *reflect(read.scene, entity.path).message();
      const std::unique_ptr<pb::Message> alone(expected.New());
      const SyntaxNode& node = outline.tree()[static_cast<int32_t>(entity.syntax)];
      const std::string body(text_of(text, node.value));
      ASSERT_TRUE(pb::util::JsonStringToMessage(body, alone.get()).ok()) << entity.path;
      ASSERT_EQ(alone->SerializeAsString(), expected.SerializeAsString()) << entity.path;
    }
  }
}

TEST(SourceMap, TellsTheEntityAtAPlace) {
  const std::string text =
      "materials { name: 'red' classic { } }\nnodes { shape { sphere { } } }\n";
  const Outline outline = edit::outline(Language::tessera, text);
  EXPECT_EQ(outline.entities()[outline.entity_at(text.find("red"))].path, "materials[0]");
  EXPECT_EQ(outline.entities()[outline.entity_at(text.find("sphere"))].path, "nodes[0].shape");
  EXPECT_EQ(outline.entities()[outline.entity_at(text.find("sphere"))].type, "sphere");
  EXPECT_EQ(outline.entities()[*outline.entity_of_path("nodes[0].shape.sphere")].path,
            "nodes[0].shape");
  EXPECT_EQ(outline.entity_named(EntityKind::material, "red"), 1);
  EXPECT_EQ(outline.entity_of_path("nodes[1]"), std::nullopt);
}

/// Texts that somebody is in the middle of typing: cut off, with bytes put in and taken out.
std::string damaged(const std::string& text, const std::vector<std::pair<size_t, char>>& hits) {
  std::string made = text;
  for (const auto& [at, c] : hits) {
    if (made.empty()) break;
    const size_t place = at % made.size();
    if (c % 3 == 0) {
      made.resize(place);
    } else if (c % 3 == 1) {
      made.erase(place, 1 + at % 5);
    } else {
      constexpr std::string_view kBytes = "{}[]<>:,;\"'#-.0aA\n\\=/\xC3";
      made.insert(place, 1, kBytes[at / 7 % kBytes.size()]);
    }
  }
  return made;
}

void check_damaged(Language language, const std::string& ending) {
  const auto all = samples(ending);
  std::string text = all[*rc::gen::inRange<size_t>(0, all.size())].text;
  if (language == Language::json) {
    const SceneWithBlobs read = decode_scene(text, SceneEncoding::text, "sample");
    text = encode_scene(read.scene, read.blobs, SceneEncoding::json);
  }
  const auto hits = *rc::gen::resize(
      6, rc::gen::container<std::vector<std::pair<size_t, char>>>(
             rc::gen::pair(rc::gen::inRange<size_t>(0, 1 << 20), rc::gen::inRange<char>(0, 100))));
  const Outline outline = edit::outline(language, damaged(text, hits));
  expect_nested(outline);
  const auto entity = static_cast<int>(*rc::gen::inRange<size_t>(0, outline.entities().size()));
  for (const Field& field : all_fields(outline, entity)) {
    const Change change = set_field(outline, entity, field.name, "3");
    if (!change.is_made()) continue;
    const std::string made = apply_edits(outline.text(), change.edits);
    RC_ASSERT(apply_edits(made, inverse_edits(outline.text(), change.edits)) == outline.text());
  }
}

RC_GTEST_PROP(SourceMap, RangesOfDamagedTesseraNest, ()) {
  check_damaged(Language::tessera, ".tessera");
}
RC_GTEST_PROP(SourceMap, RangesOfDamagedJsonNest, ()) { check_damaged(Language::json, ".tessera"); }

}  // namespace
}  // namespace tessera::edit
