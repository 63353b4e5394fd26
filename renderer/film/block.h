#pragma once

namespace tessera {

/// Adaptive sampling decides for squares of this many pixels a side, aligned in the whole frame: a
/// tile that cuts one traces all of it.
inline constexpr int kBlockSide = 4;

}  // namespace tessera
