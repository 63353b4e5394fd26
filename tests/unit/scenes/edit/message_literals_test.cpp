// Every literal of every sample, set to something else and back.
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>

#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

using Type = google::protobuf::FieldDescriptor;

struct Form {
  Language language;
  SceneEncoding encoding;
};

/// A value that the field may have and does not.
std::string other_value(const Outline& outline, int entity, const Field& field) {
  std::vector<std::string> tried{".5", ".25", "2.25", "7", "12", "19"};
  if (field.kind == ValueKind::choice || field.kind == ValueKind::boolean) tried = field.choices;
  if (field.kind == ValueKind::text || field.kind == ValueKind::file ||
      field.kind == ValueKind::reference)
    tried = {"it's \"a\\b\"\n\xC3\xA9"};
  for (const std::string& value : tried) {
    const Change change = set_field(outline, entity, field.name, value);
    if (change.is_made() && !change.edits.empty()) return value;
  }
  ADD_FAILURE() << "nothing can be set for " << field.name << " = " << field.text;
  return "";
}

void set_reflected(v1::Scene& scene, const std::string& path, const std::string& value) {
  const ReflectedPath at = reflect(scene, path);
  const auto& reflection = *at.holder->GetReflection();
  const bool many = at.field->is_repeated();
  double number = 0;
  std::from_chars(value.data(), value.data() + value.size(), number);
  const auto put = [&](auto set, auto set_many, auto given) {
    if (many) {
      (reflection.*set_many)(at.holder, at.field, at.index, given);
    } else {
      (reflection.*set)(at.holder, at.field, given);
    }
  };
  using R = google::protobuf::Reflection;
  switch (at.field->cpp_type()) {
    case Type::CPPTYPE_DOUBLE:
      return put(&R::SetDouble, &R::SetRepeatedDouble, number);
    case Type::CPPTYPE_FLOAT:
      return put(&R::SetFloat, &R::SetRepeatedFloat, static_cast<float>(number));
    case Type::CPPTYPE_UINT32:
      return put(&R::SetUInt32, &R::SetRepeatedUInt32, static_cast<uint32_t>(number));
    case Type::CPPTYPE_INT32:
      return put(&R::SetInt32, &R::SetRepeatedInt32, static_cast<int32_t>(number));
    case Type::CPPTYPE_BOOL:
      return put(&R::SetBool, &R::SetRepeatedBool, value == "true");
    case Type::CPPTYPE_STRING:
      return put(&R::SetString, &R::SetRepeatedString, value);
    case Type::CPPTYPE_ENUM:
      return reflection.SetEnum(at.holder, at.field, at.field->enum_type()->FindValueByName(value));
    default:
      FAIL() << at.field->full_name();
  }
}

/// Sets fields one by one, and reads what becomes of some of them at once with the real reader.
class LiteralCheck {
 public:
  LiteralCheck(const std::string& text, const Form& form)
      : form_(form), outline_(edit::outline(form.language, text)) {
    scene_ = expected_ = decode_scene(text, form.encoding, "sample").scene;
  }

  size_t run() {
    for (size_t i = 0; i < outline_.entities().size(); ++i)
      for (const Field& field : outline_.entities()[i].fields) {
        if (field.kind == ValueKind::list || field.kind == ValueKind::data) continue;
        if (field.kind == ValueKind::vector || field.kind == ValueKind::color) {
          parts(static_cast<int>(i), field);
        } else {
          set(static_cast<int>(i), field);
        }
        if (testing::Test::HasFatalFailure()) return count_;
      }
    read();
    return count_;
  }

 private:
  /// Of a vector, the parts that stand there.
  void parts(int entity, const Field& field) {
    const SyntaxTree& tree = outline_.tree();
    const int32_t last = tree.node_at(field.value.end - 1);
    int32_t vector = last;
    while (vector > 0 && tree[vector].value != field.value) vector = tree[vector].parent;
    for (int32_t i = tree[vector].first_child; i >= 0; i = tree[i].next) {
      Field one = field;
      one.name = field.name + "." + tree[i].field->name();
      one.kind = ValueKind::number;
      one.value = tree[i].value;
      set(entity, one);
    }
  }

  void set(int entity, const Field& field) {
    const std::string value = other_value(outline_, entity, field);
    const Change change = set_field(outline_, entity, field.name, value);
    ASSERT_EQ(change.edits.size(), 1u);
    ASSERT_EQ(change.edits[0].range, field.value) << "more than its literal changes";
    edits_.push_back(change.edits[0]);
    const std::string& holder = outline_.entities()[static_cast<size_t>(entity)].path;
    set_reflected(expected_, (holder.empty() ? "" : holder + ".") + field.name, value);
    ++count_;
    constexpr size_t kAtOnce = 40;
    if (edits_.size() >= kAtOnce) read();
  }

  void read() {
    std::sort(edits_.begin(), edits_.end(),
              [](const TextEdit& a, const TextEdit& b) { return a.range.begin < b.range.begin; });
    const std::string made = apply_edits(outline_.text(), edits_);
    const SceneWithBlobs read = decode_scene(made, form_.encoding, "made");
    ASSERT_EQ(serialize_scene(read.scene), serialize_scene(expected_));
    ASSERT_EQ(apply_edits(made, inverse_edits(outline_.text(), edits_)), outline_.text());
    edits_.clear();
    expected_ = scene_;
  }

  Form form_;
  Outline outline_;
  v1::Scene scene_, expected_;
  std::vector<TextEdit> edits_;
  size_t count_ = 0;
};

size_t check_all(const std::string& text, const Form& form) {
  return LiteralCheck(text, form).run();
}

TEST(StudioEdit, SetsEveryLiteralOfEveryTesseraSample) {
  for (const SampleText& sample : samples(".tessera")) {
    SCOPED_TRACE(sample.name);
    EXPECT_GT(check_all(sample.text, {Language::tessera, SceneEncoding::text}), 10u);
    if (HasFatalFailure()) return;
  }
}

TEST(StudioEdit, SetsEveryLiteralOfEverySampleAsJson) {
  for (const SampleText& sample : samples(".tessera")) {
    SCOPED_TRACE(sample.name);
    const SceneWithBlobs scene = decode_scene(sample.text, SceneEncoding::text, "sample");
    const std::string text = encode_scene(scene.scene, scene.blobs, SceneEncoding::json);
    EXPECT_GT(check_all(text, {Language::json, SceneEncoding::json}), 10u);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace tessera::edit
