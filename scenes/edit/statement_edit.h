#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "scenes/edit/edit.h"
#include "scenes/edit/syntax_tree.h"
#include "scenes/edit/vocabulary.h"

namespace tessera::edit {

// Languages of one statement a line: .mtl with its materials, and of .obj the lines that name
// objects, groups, materials and files.
SyntaxTree parse_statements(std::string_view text, bool is_mtl);
std::vector<Entity> statement_entities(std::string_view text, const SyntaxTree& tree);
std::vector<Field> all_statement_fields(const Outline& outline, int entity);

Completions statement_completions(const Outline& outline, size_t offset);
std::optional<Hover> statement_hover(const Outline& outline, size_t offset);

Change set_statement(const Outline& outline, int entity, std::string_view field,
                     std::string_view value);
Change reset_statement(const Outline& outline, int entity, std::string_view field);
Change remove_statements(const Outline& outline, int entity);
Change duplicate_statements(const Outline& outline, int entity);

}  // namespace tessera::edit
