#pragma once

#include <cmath>
#include <numbers>
#include <string>

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

}  // namespace tessera
