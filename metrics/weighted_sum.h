#pragma once

#include <cstddef>
#include <span>

namespace tessera {

/// out[x] = the sum of weights[k] * rows[k][x] for all x below `count`, added in the order of k.
/// Takes the best instruction set of this machine; all give the same bits. `out` may not overlap a
/// row.
void weighted_sum(float* out, size_t count, std::span<const float> weights,
                  std::span<const float* const> rows);
void weighted_sum(double* out, size_t count, std::span<const double> weights,
                  std::span<const double* const> rows);

}  // namespace tessera
