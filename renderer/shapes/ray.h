#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "renderer/math/vec.h"

namespace tessera {

/// Which sides of a surface a ray can hit.
enum class Cull : uint8_t { none, back, front };

/// Points origin + t * direction for t_min < t < t_max. The direction need not be of unit length,
/// so that a transformed ray keeps its t.
struct Ray {
  Point3 origin;
  Vec3 direction;
  double t_min = 0;
  double t_max = std::numeric_limits<double>::infinity();
  Cull cull = Cull::none;

  Point3 at(double t) const { return origin + direction * t; }
};

/// False for a ray with a part that is not finite, or no direction: it hits nothing.
inline bool can_hit(const Ray& ray) {
  const Point3& o = ray.origin;
  const Vec3& d = ray.direction;
  // Nearly always this says it all.
  if (std::isfinite(o.x + o.y + o.z + d.x + d.y + d.z) && d.x != 0) [[likely]]
    return true;
  return is_finite(o - Point3{}) && is_finite(d) && d != Vec3{};
}

/// What no Hit::instance is.
inline constexpr uint32_t kNoInstance = 0xFFFFFFFF;

/// Where a ray met a surface, and no more: 32 bytes. Of hits at equal t the one with the smaller
/// (instance, primitive) counts, whatever the accelerator.
struct Hit {
  double t = std::numeric_limits<double>::infinity();
  double u = 0;  ///< surface parameters; barycentric weights of vertices 1 and 2 of a
  double v = 0;  ///< triangle
  uint32_t instance = 0;
  uint32_t primitive = 0;  ///< within the shape: a triangle's number, a box's face

  friend bool operator==(const Hit&, const Hit&) = default;
};

}  // namespace tessera
