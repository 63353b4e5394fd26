#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "python/array_source.h"

namespace tessera {

namespace detail {

/// Copies indices; returns the bits of all, and of what each leaves to `last`, or-ed.
template <class Index>
Index copy_bits(const std::byte* __restrict from, auto count, Index last, uint32_t* __restrict to) {
  Index bits = 0;
  for (size_t i = 0; i < count; ++i) {
    const Index index = load<Index, false>(from + i * sizeof(Index));
    to[i] = static_cast<uint32_t>(index);
    bits |= index | (last - index);
  }
  return bits;
}

}  // namespace detail

/// Copies `count` indices and returns whether each is less than `limit`, which is at most half of
/// what Index holds; a negative number is a huge one here. `from` need not be aligned.
///
/// The top bit is clear in an index and in what it leaves to the limit, where the index is good.
/// Blocks of known length without a branch become vectors in every build; a maximum does not.
template <class Index>
bool copy_indices(const std::byte* from, size_t count, uint64_t limit, uint32_t* to) {
  constexpr std::integral_constant<size_t, 1024> kBlock;
  const Index last = static_cast<Index>(limit - 1);
  Index bits = 0;
  size_t at = 0;
  for (; at + kBlock <= count; at += kBlock)
    bits |= detail::copy_bits(from + at * sizeof(Index), kBlock, last, to + at);
  bits |= detail::copy_bits(from + at * sizeof(Index), count - at, last, to + at);
  return bits >> (8 * sizeof(Index) - 1) == 0;
}

/// What rounding found: the bounds of the vertices as they were given, and the largest move along
/// an axis.
struct VertexBounds {
  std::array<double, 3> least, most;
  double largest_move = 0;

  VertexBounds() {
    least.fill(std::numeric_limits<double>::infinity());
    most.fill(-std::numeric_limits<double>::infinity());
  }
  double extent() const;
};

/// Writes `count` vertices less `middle` in single precision and widens `bounds` by them. `from` is
/// three doubles a vertex and need not be aligned. What is not a number widens nothing.
void round_vertices(const std::byte* from, size_t count, const std::array<double, 3>& middle,
                    float* to, VertexBounds& bounds);

}  // namespace tessera
