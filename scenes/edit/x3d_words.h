#pragma once

#include <string_view>
#include <vector>

#include "scenes/edit/outline.h"

namespace tessera::edit {

/// What kind of entity a node of X3D is.
EntityKind x3d_entity_kind(std::string_view node);

/// What is known of a field of a node, with its kind guessed from its value where it is not on
/// record.
Field describe_x3d(std::string_view node, std::string_view field, std::string_view value);

/// How many numbers a value of that field has; 0: any number.
int x3d_parts(const Field& field);

/// The words of a list of numbers with their places, between blanks or commas.
std::vector<SourceRange> number_words(std::string_view text, SourceRange body);

}  // namespace tessera::edit
