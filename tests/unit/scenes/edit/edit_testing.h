#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "proto/wire/scene_codec.h"
#include "scenes/edit/edit.h"
#include "scenes/edit/syntax_tree.h"
#include "tests/source_folder.h"

namespace tessera::edit {

struct SampleText {
  std::string name, text;
};

inline std::string read_text(const std::filesystem::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

/// Our samples of one ending, in the order of their names.
inline std::vector<SampleText> samples(const std::string& ending) {
  std::vector<SampleText> found;
  const std::filesystem::path folder = source_folder() + "/scenes/samples";
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ending)
      found.push_back({entry.path().filename(), read_text(entry.path())});
  std::sort(found.begin(), found.end(),
            [](const SampleText& a, const SampleText& b) { return a.name < b.name; });
  EXPECT_FALSE(found.empty()) << ending;
  return found;
}

/// The message, and the index within its last field, that a path such as "nodes[3].shape" names.
struct ReflectedPath {
  google::protobuf::Message* holder = nullptr;
  const google::protobuf::FieldDescriptor* field = nullptr;
  int index = 0;

  google::protobuf::Message* message() const {
    const auto& reflection = *holder->GetReflection();
    return field->is_repeated() ? reflection.MutableRepeatedMessage(holder, field, index)
                                : reflection.MutableMessage(holder, field);
  }
};

inline ReflectedPath reflect(google::protobuf::Message& root, std::string path) {
  ReflectedPath at{&root, nullptr, 0};
  while (!path.empty()) {
    if (at.field) at = {at.message(), nullptr, 0};
    const size_t dot = path.find('.');
    std::string first = path.substr(0, dot);
    path = dot == std::string::npos ? "" : path.substr(dot + 1);
    if (const size_t bracket = first.find('['); bracket != std::string::npos) {
      at.index = std::stoi(first.substr(bracket + 1));
      first.resize(bracket);
    }
    at.field = at.holder->GetDescriptor()->FindFieldByName(first);
    EXPECT_NE(at.field, nullptr) << first;
    if (!at.field) break;
  }
  return at;
}

inline std::string applied(const Outline& outline, const Change& change) {
  EXPECT_TRUE(change.is_made()) << change.refusal->found << "; " << change.refusal->expected;
  return apply_edits(outline.text(), change.edits);
}

inline std::string refusal_of(const Change& change) {
  return change.refusal ? change.refusal->found + "; " + change.refusal->expected : "none";
}

/// Every range lies inside the text and its parent's, and siblings ascend.
inline void expect_nested(const Outline& outline) {
  const SyntaxTree& tree = outline.tree();
  const auto size = static_cast<uint32_t>(outline.text().size());
  for (int32_t i = 0; i < tree.size(); ++i) {
    const SyntaxNode& node = tree[i];
    ASSERT_LE(node.range.begin, node.range.end);
    ASSERT_LE(node.range.end, size);
    ASSERT_TRUE(node.range.contains(node.value)) << i;
    ASSERT_TRUE(node.value.contains(node.body)) << i;
    ASSERT_LE(node.body.begin, node.body.end);
    if (node.parent >= 0) {
      ASSERT_TRUE(tree[node.parent].range.contains(node.range)) << i;
    }
    if (node.next >= 0) {
      ASSERT_LE(node.range.end, tree[node.next].range.begin) << i;
    }
  }
  for (const Entity& entity : outline.entities()) {
    ASSERT_LE(entity.range.end, size);
    if (entity.parent < 0) continue;
    ASSERT_TRUE(
        outline.entities()[static_cast<size_t>(entity.parent)].range.contains(entity.range));
    for (const Field& field : entity.fields) {
      ASSERT_TRUE(entity.range.contains(field.range)) << field.name;
      ASSERT_TRUE(field.range.contains(field.value)) << field.name;
    }
  }
}

}  // namespace tessera::edit
