#pragma once

#include "renderer/math/transform.h"

namespace tessera {

/// Between two turns about the origin, which have no scale: at share `s` of the way, in [0, 1], at
/// constant speed about one axis along the shorter arc (Shoemake, Animating Rotation with
/// Quaternion Curves, 1985).
Affine mix_turns(const Affine& from, const Affine& to, double s);

/// Between two transforms, each taken apart into shift, turn and stretch (Shoemake and Duff, Matrix
/// Animation and Polar Decomposition, 1992): the turn as in mix_turns(), the others linearly, so
/// that a body that turns keeps its size. Linear in each number where one of them is flat.
Affine mix_matrices(const Affine& from, const Affine& to, double s);

}  // namespace tessera
