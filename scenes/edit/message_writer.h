#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/edit/edit.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// A field that is to be written: a scalar with its literal, or a message with its fields.
struct Draft {
  const google::protobuf::FieldDescriptor* field = nullptr;
  std::string literal;
  std::vector<Draft> parts;
};

/// Writes fields into a text of a scene's message, in the style of what stands there: .tessera and
/// .json. What is not of that message is of glTF, too.
class MessageWriter {
 public:
  explicit MessageWriter(const Outline& outline);

  bool is_json() const { return is_json_; }
  /// The literal of a value that check_value allows, with the quotes of `old`.
  std::string literal(const google::protobuf::FieldDescriptor& field, std::string_view typed,
                      std::string_view old) const;
  /// Inserts fields into the message at `parent`, each beside its siblings in the order of the
  /// schema.
  std::vector<TextEdit> insert(int32_t parent, const std::vector<Draft>& drafts) const;
  /// Inserts `copy` behind the node, which may be there several times.
  TextEdit insert_behind(int32_t node, std::string_view copy) const;
  TextEdit remove(int32_t node) const;

  // Of any JSON: an item or member at the end of the list or block, and such texts.
  TextEdit append(int32_t parent, std::string_view item) const;
  std::string json_member(std::string_view name, std::string_view value) const;
  std::string json_list(const std::vector<std::string>& items) const;
  std::string json_block(
      const std::vector<std::pair<std::string_view, std::string>>& members) const;

 private:
  std::string render(const Draft& draft) const;
  std::string render_value(const Draft& draft) const;
  TextEdit insert_one(int32_t parent, const Draft& draft) const;
  TextEdit insert_into_empty(int32_t parent, const std::string& text) const;
  TextEdit append_to_list(int32_t list, const std::string& item) const;
  TextEdit behind(int32_t sibling, std::string_view made) const;
  TextEdit before(int32_t sibling, std::string_view made) const;
  TextEdit remove_from_list(int32_t node) const;
  /// Behind a separator that follows `end`, which only the text format may have or not.
  uint32_t behind_separator(uint32_t end) const;
  bool ends_line(uint32_t offset) const;
  bool is_separated(int32_t node) const;

  std::string_view text_;
  const SyntaxTree& tree_;
  bool is_json_;
  std::string colon_ = ": ", comma_ = ", ";
};

}  // namespace tessera::edit
