#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "renderer/math/vec.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {

inline constexpr double kPi = std::numbers::pi;

inline std::string number(double v) { return std::to_string(v); }
inline std::string grey(double v) {
  return "{ value { r: " + number(v) + " g: " + number(v) + " b: " + number(v) + " } }";
}
inline std::string node(const std::string& shape, const std::string& material) {
  return "nodes { shape { materials: '" + material + "' " + shape + " } } ";
}
/// Looks along -z at [0, width] x [0, height], y upwards, one unit to the pixel.
inline std::string map_camera(double width, double height, const std::string& more = "") {
  return "cameras { world_from_camera { steps { translate { z: 100 } } } orthographic { min_x: 0 "
         "min_y: 0 max_x: " +
         number(width) + " max_y: " + number(height) + " } " + more + " } ";
}
inline std::string samples(uint32_t count) {
  return "settings { sampling { samples_per_pixel: " + std::to_string(count) + " } } ";
}

inline const std::string kGlow = "materials { name: 'glow' unlit { } } ";

/// What a polygon of radiance 1 brings to the origin of normal +z, cut off at the horizon (Lambert
/// 1760): half of the sum over its edges of their angle times the height of the unit normal of
/// their plane.
inline double irradiance(const std::vector<Vec3>& corners) {
  std::vector<Vec3> above;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if (a.z >= 0) above.push_back(a);
    if ((a.z >= 0) != (b.z >= 0)) above.push_back(a + (b - a) * (a.z / (a.z - b.z)));
  }
  double sum = 0;
  for (size_t i = 0; i < above.size(); ++i) {
    const Vec3 a = normalize(above[i]), b = normalize(above[(i + 1) % above.size()]);
    const Vec3 across = cross(a, b);
    if (!(length(across) > 0)) continue;
    sum += std::atan2(length(across), dot(a, b)) * across.z / length(across);
  }
  return std::abs(sum) / 2;
}

}  // namespace tessera
