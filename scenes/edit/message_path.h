#pragma once

#include <google/protobuf/descriptor.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/edit/edit.h"
#include "scenes/edit/message_writer.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// Where a dotted path of fields leads to in a text.
struct MessagePath {
  int32_t node = 0;  ///< the innermost message of it that the text has
  /// The fields of the messages that the text lacks between `node` and the last one.
  std::vector<const google::protobuf::FieldDescriptor*> missing{};
  const google::protobuf::FieldDescriptor* field = nullptr;  ///< the last one
  int32_t leaf = -1;                                         ///< its node; -1: to be inserted
  std::optional<Refusal> refusal{};
};

/// Follows "sphere.center", "materials[0]", "steps[1].rotate.angle" from the message at `node`. A
/// repeated field without an index, or with the index behind its last, is one to be added.
MessagePath find_field(const SyntaxTree& tree, int32_t node, std::string_view path);

/// The message in a draft that `path` names a field of; messages on the way are made.
struct DraftPlace {
  Draft* holder = nullptr;
  const google::protobuf::FieldDescriptor* field = nullptr;
  std::optional<Refusal> refusal{};
};
DraftPlace find_draft(Draft& draft, std::string_view path);

/// The names of a message's fields, between commas.
std::string field_list(const google::protobuf::Descriptor& type);

}  // namespace tessera::edit
