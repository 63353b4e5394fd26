#pragma once

#include <string_view>

#include "scenes/edit/outline.h"
#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// What an X3D document measures in, as its UNIT statements say.
struct X3dUnits {
  double length = 1;  ///< metres
  double angle = 1;   ///< radians
};

X3dUnits x3d_units(std::string_view text, const SyntaxTree& tree, bool is_classic);
X3dUnits x3d_units(const Outline& outline);

/// The field as such a document has it: without the limits, unit and default of another unit.
Field in_units(Field field, const X3dUnits& units);

}  // namespace tessera::edit
