#include "python/array_kernels.h"

#include <bit>
#include <cstring>

namespace tessera {
namespace {

// Two numbers at a time; three such pairs are two vertices.
using TwoDoubles = double __attribute__((vector_size(16)));
using TwoLongs = int64_t __attribute__((vector_size(16)));
using TwoFloats = float __attribute__((vector_size(8)));
constexpr size_t kPairs = 3, kNumbers = 2 * kPairs;

struct PairBounds {
  TwoDoubles least, most, middle, move{};
};

/// The axis of a lane of a pair.
constexpr size_t axis_of(size_t pair, size_t lane) { return (2 * pair + lane) % 3; }

void round_two(const std::byte* from, PairBounds (&bounds)[kPairs], float* to) {
  for (size_t pair = 0; pair < kPairs; ++pair) {
    PairBounds& of = bounds[pair];
    TwoDoubles given;
    std::memcpy(&given, from + pair * sizeof given, sizeof given);
    of.least = given < of.least ? given : of.least;
    of.most = given > of.most ? given : of.most;
    const TwoDoubles moved = given - of.middle;
    const TwoFloats rounded = __builtin_convertvector(moved, TwoFloats);
    std::memcpy(to + 2 * pair, &rounded, sizeof rounded);
    const TwoDoubles by = __builtin_convertvector(rounded, TwoDoubles) - moved;
    const auto absolute = std::bit_cast<TwoDoubles>(std::bit_cast<TwoLongs>(by) &
                                                    std::numeric_limits<int64_t>::max());
    of.move = absolute > of.move ? absolute : of.move;
  }
}

}  // namespace

double VertexBounds::extent() const {
  double extent = 0;
  for (size_t axis = 0; axis < 3; ++axis) extent = std::max(extent, most[axis] - least[axis]);
  return extent;
}

void round_vertices(const std::byte* from, size_t count, const std::array<double, 3>& middle,
                    float* to, VertexBounds& bounds) {
  constexpr size_t kVertexBytes = 3 * sizeof(double);
  PairBounds pairs[kPairs];
  const auto each_lane = [&](const auto& use) {
    for (size_t pair = 0; pair < kPairs; ++pair)
      for (size_t lane = 0; lane < 2; ++lane) use(pairs[pair], lane, axis_of(pair, lane));
  };
  each_lane([&](PairBounds& of, size_t lane, size_t axis) {
    of.least[lane] = bounds.least[axis];
    of.most[lane] = bounds.most[axis];
    of.middle[lane] = middle[axis];
  });
  for (; count >= 2; count -= 2, from += 2 * kVertexBytes, to += kNumbers)
    round_two(from, pairs, to);
  if (count > 0) {
    std::byte twice[2 * kVertexBytes];
    float rounded[kNumbers];
    std::memcpy(twice, from, kVertexBytes);
    std::memcpy(twice + kVertexBytes, from, kVertexBytes);
    round_two(twice, pairs, rounded);
    std::copy_n(rounded, 3, to);
  }
  each_lane([&](const PairBounds& of, size_t lane, size_t axis) {
    bounds.least[axis] = std::min<double>(bounds.least[axis], of.least[lane]);
    bounds.most[axis] = std::max<double>(bounds.most[axis], of.most[lane]);
    bounds.largest_move = std::max<double>(bounds.largest_move, of.move[lane]);
  });
}

}  // namespace tessera
