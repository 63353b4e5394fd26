#include "renderer/math/vec.h"

namespace tessera {

Vec3 normalize_extreme(const Vec3& v) {
  const double largest = max_component(abs(v));
  if (!(largest > 0) || !std::isfinite(largest)) return v / largest;  // no direction: NaN
  // Scaled by a power of two first, which rounds nothing.
  const double scale = std::ldexp(1.0, -std::ilogb(largest));
  const Vec3 scaled = v * scale;
  return scaled / std::sqrt(dot(scaled, scaled));
}

}  // namespace tessera
