#pragma once

#include <string_view>

#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// SyntaxNode::type of a script's nodes.
enum class CrtPart : int16_t {
  script,
  settings,
  scene,
  object,      ///< name; children: attributes
  group,       ///< Union, Intersection or Difference; children: expressions
  attribute,   ///< name; child: value
  assignment,  ///< children: target (identifier), value
  macro,       ///< children: parameters, then statements
  parameter,
  loop,    ///< children: condition, then statements
  branch,  ///< children: condition, then statements
  block,
  call,       ///< name, where it is called by one; children: arguments
  list,       ///< children: items
  modifiers,  ///< children: the modified, then modifiers
  modifier,   ///< name; child: value
  integer,    ///< with a sign before it
  real,
  text,
  boolean,
  identifier,
  computed,  ///< operators; children: operands
};

inline CrtPart crt_part(const SyntaxNode& node) { return static_cast<CrtPart>(node.type); }

SyntaxTree parse_crt_syntax(std::string_view text);

}  // namespace tessera::edit
