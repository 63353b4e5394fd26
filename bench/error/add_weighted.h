#pragma once

#include <cstddef>
#include <span>

namespace tessera {

/// out[x] = the sum of weights[k] * rows[k][x] for all x below `count`, added in the order of k:
/// the same bits by every instruction set, of which the best that this machine has is taken. `out`
/// may not overlap a row.
void add_weighted(float* out, size_t count, std::span<const float> weights,
                  std::span<const float* const> rows);

}  // namespace tessera
