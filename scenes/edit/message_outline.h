#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/edit/outline.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// The entities of a text that holds a scene's message: .tessera and .json.
std::vector<Entity> message_entities(std::string_view text, const SyntaxTree& tree);
std::vector<Field> all_message_fields(const Outline& outline, int entity);

/// The characters that a literal in quotes stands for, of both languages.
std::string unquote(std::string_view literal);
/// `text` in quotes of that kind.
std::string quote(std::string_view text, char mark, bool is_json);

/// What a scalar or a vector says, for people.
std::string shown_value(std::string_view text, const SyntaxTree& tree, int32_t node);

/// The children of `parent` that are of `field`, the items of its lists among them, in the order of
/// the text.
std::vector<int32_t> occurrences(const SyntaxTree& tree, int32_t parent,
                                 const google::protobuf::FieldDescriptor* field);

}  // namespace tessera::edit
