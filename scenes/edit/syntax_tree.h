#pragma once

#include <google/protobuf/descriptor.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "scenes/edit/source_text.h"

namespace tessera::edit {

enum class SyntaxKind : uint8_t {
  block,   ///< holds named children: a message, an object, an element
  list,    ///< holds children without names
  scalar,  ///< one value
  note,    ///< what has a place and a name alone
};

/// A piece of a text with its place. Pieces nest properly.
struct SyntaxNode {
  SyntaxKind kind = SyntaxKind::scalar;
  bool is_closed = true;  ///< its bracket or quote is closed
  SourceRange range{};    ///< from the first byte of its name to the last of its value
  SourceRange name{};     ///< without quotes; empty: it has none
  SourceRange value{};    ///< with its brackets or quotes
  SourceRange body{};     ///< without them
  int32_t parent = -1, first_child = -1, last_child = -1, next = -1;
  /// In the languages of the scene's message; null: not in the schema.
  const google::protobuf::FieldDescriptor* field = nullptr;
  const google::protobuf::Descriptor* message = nullptr;  ///< of a block
  int16_t type = 0;  ///< elsewhere, what the language's own parser says of it
};

/// A text taken apart: every node knows its bytes, whatever is wrong with the text. The first node
/// is the whole text.
class SyntaxTree {
 public:
  int32_t add(int32_t parent, SyntaxNode node) {
    const auto made = static_cast<int32_t>(nodes_.size());
    node.parent = parent;
    nodes_.push_back(node);
    if (parent >= 0) {
      SyntaxNode& above = nodes_[static_cast<size_t>(parent)];
      if (above.last_child < 0) {
        above.first_child = made;
      } else {
        nodes_[static_cast<size_t>(above.last_child)].next = made;
      }
      above.last_child = made;
    }
    return made;
  }
  SyntaxNode& operator[](int32_t i) { return nodes_[static_cast<size_t>(i)]; }
  const SyntaxNode& operator[](int32_t i) const { return nodes_[static_cast<size_t>(i)]; }
  int32_t size() const { return static_cast<int32_t>(nodes_.size()); }

  /// The innermost node whose range holds `offset`.
  int32_t node_at(size_t offset) const {
    int32_t found = 0;
    for (int32_t i = nodes_[0].first_child; i >= 0;) {
      const SyntaxNode& node = (*this)[i];
      if (node.range.contains(offset) && !node.range.is_empty()) {
        found = i;
        i = node.first_child;
      } else {
        i = node.next;
      }
    }
    return found;
  }

 private:
  std::vector<SyntaxNode> nodes_;
};

SyntaxTree parse_tessera(std::string_view text);
SyntaxTree parse_json(std::string_view text, bool is_scene);

}  // namespace tessera::edit
