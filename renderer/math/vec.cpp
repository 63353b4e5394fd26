#include "renderer/math/vec.h"

namespace tessera {

Vec3 normalize(const Vec3& v) {
  const double squared = dot(v, v);
  // Squares of very short or long vectors leave the range of double: scale by a power of two first,
  // which rounds nothing.
  if (!(squared > 1e-280 && squared < 1e280)) [[unlikely]] {
    const double largest = max_component(abs(v));
    if (!(largest > 0) || !std::isfinite(largest)) return v / largest;  // no direction: NaN
    const double scale = std::ldexp(1.0, -std::ilogb(largest));
    const Vec3 scaled = v * scale;
    return scaled / std::sqrt(dot(scaled, scaled));
  }
  return v / std::sqrt(squared);
}

}  // namespace tessera
