#include "scenes/mesh/point_table.h"

#include <algorithm>
#include <bit>

namespace tessera {
namespace {

/// Mixes the coordinates' bits (the finisher of MurmurHash3); points on a grid differ in few bits.
uint64_t hash_of(const float* p) {
  uint64_t h = 0;
  for (int a = 0; a < 3; ++a) {
    h ^= std::bit_cast<uint32_t>(p[a]) + (h << 32 | h >> 32);
    h *= 0xFF51AFD7ED558CCDull;
    h ^= h >> 33;
  }
  return h;
}

}  // namespace

size_t PointTable::find_slot(const float* point) const {
  const size_t mask = slots_.size() - 1;
  size_t slot = hash_of(point) & mask;
  while (slots_[slot] != kEmpty &&
         !std::equal(point, point + 3, points_.data() + size_t{slots_[slot]} * 3))
    slot = (slot + 1) & mask;
  return slot;
}

void PointTable::grow() {
  slots_.assign(slots_.size() * 2, kEmpty);
  for (uint32_t i = 0; i < points_.size() / 3; ++i)
    slots_[find_slot(points_.data() + size_t{i} * 3)] = i;
}

uint32_t PointTable::add(const std::array<float, 3>& point) {
  const std::array<float, 3> key{point[0] + 0.f, point[1] + 0.f, point[2] + 0.f};  // -0 is 0
  const size_t slot = find_slot(key.data());
  if (slots_[slot] != kEmpty) return slots_[slot];
  const auto number = static_cast<uint32_t>(points_.size() / 3);
  slots_[slot] = number;
  points_.insert(points_.end(), key.begin(), key.end());
  if (points_.size() / 3 * 2 > slots_.size()) grow();
  return number;
}

}  // namespace tessera
