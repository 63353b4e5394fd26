#pragma once

#include <array>
#include <string>

#include "scenes/edit/edit.h"

namespace tessera::edit {

/// How a scene places another file: it is scaled and mirrored, turned about z, y and x, in this
/// order, and moved; a CRT script turns about x, y and z. Numbers are as they are typed.
struct Placement {
  std::string file;
  std::string material;  ///< in place of its own ones; empty: its own
  std::array<std::string, 3> position{"0", "0", "0"};
  std::array<std::string, 3> rotation{"0", "0", "0"};  ///< degrees about x, y and z
  std::array<std::string, 3> scale{"1", "1", "1"};     ///< above 0
  std::array<bool, 3> flip{};                          ///< mirrored along x, y and z
};

struct WrittenPlacement {
  Placement placement;
  std::string locked;        ///< why nothing of it is set as one; empty where all of it is
  bool has_material = true;  ///< whether the language lets a scene choose the material
};
/// The placement of an include; that of a new one where the entity is none.
WrittenPlacement read_placement(const Outline& outline, int entity);

/// Gives the include that placement: values that are equal to what the text says are left as they
/// stand there.
Change set_placement(const Outline& outline, int entity, const Placement& placement);

/// A new include.
Change add_placement(const Outline& outline, const Placement& placement);

}  // namespace tessera::edit
