#pragma once

#include "renderer/math/vec.h"

namespace tessera {

/// The direction, of unit length, from which what came without a camera is seen: from the front,
/// the right and above.
inline Vec3 three_quarters() { return normalize(Vec3{0.55, 0.38, 1}); }

}  // namespace tessera
