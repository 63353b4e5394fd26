#pragma once

#include <cstdint>
#include <deque>
#include <string_view>
#include <vector>

#include "scenes/formats/crt/crt_diagnostics.h"
#include "scenes/formats/crt/crt_lexer.h"

namespace tessera {

enum class CrtKind : uint8_t {
  integer,
  real,
  text,
  boolean,
  identifier,
  list,
  object,      ///< name; children: attributes
  group,       ///< Union, Intersection or Difference with children: expressions
  attribute,   ///< name; child: value
  macro,       ///< children: parameters (identifiers), then the body (block)
  index,       ///< children: the indexed, the index
  call,        ///< children: the called, the arguments
  modifiers,   ///< children: the modified, then modifiers
  modifier,    ///< token: which; child: value
  unary,       ///< token, child
  binary,      ///< token, children
  ternary,     ///< condition, yes, no
  assignment,  ///< target (identifier), value
  loop,        ///< condition, block
  branch,      ///< condition, block, and a block or branch if there is an else
  block,       ///< statements
  settings,    ///< attributes
  scene,       ///< statements
};

/// A node of the syntax tree. Left-leaning chains (a + b + c, a[0][1]) may be as deep as the script
/// is long: walk them in a loop. Everything else nests at most CrtParser::kMaxDepth deep.
struct CrtSyntax {
  CrtKind kind = CrtKind::block;
  CrtToken token = CrtToken::end;
  CrtSpan span;           ///< where a message about it points
  std::string_view text;  ///< name, or the literal as written
  std::vector<const CrtSyntax*> children;
};

/// Nodes live here, so that a deep tree is dropped without recursion.
using CrtSyntaxPool = std::deque<CrtSyntax>;

}  // namespace tessera
