#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "scenes/edit/outline.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// What a script calls by one name.
struct CrtVariable {
  int assigned = 0;     ///< how many times, parameters and loops among them
  int uses = 0;         ///< places that read it
  int32_t value = -1;   ///< the node of what was assigned last
  bool is_top = false;  ///< assigned at the top level, where nothing hides it
};
using CrtVariables = std::unordered_map<std::string_view, CrtVariable>;
CrtVariables crt_variables(std::string_view text, const SyntaxTree& tree);

std::vector<Entity> crt_entities(std::string_view text, const SyntaxTree& tree);
std::vector<Field> all_crt_fields(const Outline& outline, int entity);

/// The node with the literal that the value at `node` stands for: itself, or what its variable is
/// assigned once; -1 where it is computed.
int32_t crt_literal(std::string_view text, const SyntaxTree& tree, const CrtVariables& variables,
                    int32_t node);
bool is_crt_vector(std::string_view text, const SyntaxNode& node);

}  // namespace tessera::edit
