#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "renderer/math/vec.h"
#include "tests/uniform_numbers.h"

namespace tessera {

/// What random scenes in text form are made of; of sizes from 2^-12 to 2^12.
class RandomScene {
 protected:
  explicit RandomScene(uint32_t seed) : random_(seed), size_(std::exp2(pick(-12, 13))) {}

  /// In [from, to).
  int pick(int from, int to) { return static_cast<int>(std::floor(random_.between(from, to))); }
  bool chance(double share) { return random_.between(0, 1) < share; }
  Vec3 vec(double scale = 1) {
    const double s = size_ * scale;
    return {random_.between(-s, s), random_.between(-s, s), random_.between(-s, s)};
  }
  static std::string xyz(const Vec3& v) {
    return fmt::format("x: {:.17g} y: {:.17g} z: {:.17g}", v.x, v.y, v.z);
  }
  std::string rgb(double most = 1) {
    return fmt::format("r: {:.3f} g: {:.3f} b: {:.3f}", random_.between(0, most),
                       random_.between(0, most), random_.between(0, most));
  }

  UniformNumbers random_;
  double size_;
};

}  // namespace tessera
