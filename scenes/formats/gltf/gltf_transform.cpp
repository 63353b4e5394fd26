#include "scenes/formats/gltf/gltf_transform.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {

Affine gltf_rotation(const std::vector<double>& q, const GltfValue& place, double rounding) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double squared = x * x + y * y + z * z + w * w, length = std::sqrt(squared);
  if (squared < std::numeric_limits<double>::min()) {
    place.repair("a quaternion of length 0", "a unit one", "nothing is turned");
    return {};
  }
  if (std::abs(length - 1) > rounding)
    place.repair(fmt::format("a quaternion of length {:.4g}", length), "a unit one",
                 "its direction is taken");
  const double s = 2 / squared;
  Affine r;
  r.m[0] = {1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y), 0};
  r.m[1] = {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x), 0};
  r.m[2] = {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y), 0};
  return r;
}

Affine gltf_matrix(const std::vector<double>& columns, const GltfValue& place) {
  constexpr double kRounding = 1e-5;
  Affine out;
  double largest = 1;  // of the 3x3 part
  for (size_t i = 0; i < columns.size(); ++i) {
    if (i % 4 == 3) continue;
    out.m[i % 4][i / 4] = columns[i];
    if (i < 12) largest = std::max(largest, std::abs(columns[i]));
  }
  for (size_t i = 3; i < columns.size(); i += 4)
    if (!(std::abs(columns[i] - (i == 15 ? 1 : 0)) <= kRounding * largest))
      place.repair(fmt::format("a last row of {} {} {} {}", columns[3], columns[7], columns[11],
                               columns[15]),
                   "0 0 0 1", "that is taken");
  return out;
}

Affine gltf_transform(const GltfValue& node) {
  constexpr size_t kNumbers = 16;
  const GltfValue matrix = node["matrix"];
  if (matrix.size() >= kNumbers) {
    if (node["translation"] || node["rotation"] || node["scale"])
      node.repair("a matrix beside translation, rotation or scale", "one or the other",
                  "the matrix is taken");
    return gltf_matrix(matrix.numbers({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}), matrix);
  }
  if (matrix.size() > 0)
    matrix.repair(fmt::format("an array of {}", matrix.size()), "16 numbers", "it is left out");
  const auto vec = [&](const char* key, double without) {
    const auto v = node[key].numbers({without, without, without});
    return Vec3{v[0], v[1], v[2]};
  };
  const Affine shift = translation(vec("translation", 0));
  const GltfValue rotation = node["rotation"];
  constexpr double kDecimals = 1e-3;  // that programs write
  const Affine turn = gltf_rotation(rotation.numbers({0, 0, 0, 1}), rotation, kDecimals);
  return shift * turn * scaling(vec("scale", 1));
}

}  // namespace tessera
