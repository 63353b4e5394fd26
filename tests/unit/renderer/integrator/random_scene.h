#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "proto/wire/blob_store.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/ray.h"
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

  /// With smooth normals, with vertex colours, or without; `is_opaque`: all that it has.
  std::string mesh(bool is_opaque) {
    const int vertices = pick(4, 12), triangles = pick(1, 20);
    std::string text = "mesh { inline_positions: [";
    for (int i = 0; i < vertices; ++i) {
      const Vec3 p = vec();
      text += fmt::format("{}{:.9g}, {:.9g}, {:.9g}", i > 0 ? ", " : "", p.x, p.y, p.z);
    }
    text += "] inline_triangles: [";
    for (int i = 0; i < triangles; ++i) {
      const int a = pick(0, vertices);
      text += fmt::format("{}{}, {}, {}", i > 0 ? ", " : "", a, (a + 1) % vertices,
                          (a + pick(2, vertices)) % vertices);
    }
    text += "] ";
    const bool along_axes = chance(.3);
    if (chance(.5)) {
      text += "inline_normals: [";
      for (int i = 0; i < vertices; ++i) {
        const Vec3 n = along_axes ? Vec3{-1, -0.0, chance(.5) ? -0.0 : 0} : vec(1 / size_);
        text += fmt::format("{}{:.9g}, {:.9g}, {:.9g}", i > 0 ? ", " : "", n.x, n.y, n.z);
      }
      text += "] ";
    }
    if (chance(.3)) text += colors(vertices, is_opaque);
    return text + "}";
  }
  std::string colors(int vertices, bool is_opaque) {
    std::vector<float> values;
    for (int i = 0; i < 4 * vertices; ++i)
      values.push_back(i % 4 == 3 && is_opaque ? 1 : static_cast<float>(random_.between(0, 1)));
    return blob("colors", values);
  }
  std::string blob(const char* field, const std::vector<float>& values) {
    const size_t size = values.size() * sizeof(float);
    const auto* const begin = reinterpret_cast<const std::byte*>(values.data());
    const Digest digest = blobs_.put(std::vector<std::byte>(begin, begin + size));
    return fmt::format("{} {{ digest: '{}' size: {} }} ", field, digest.hex(), size);
  }
  /// Rays from about one place to about one place.
  std::vector<Ray> beam(size_t count) {
    const Vec3 from = vec(2), to = vec(.5);
    const double width = std::exp2(random_.between(-12, -3));
    std::vector<Ray> rays;
    for (size_t i = 0; i < count; ++i) {
      const Vec3 origin = from + vec(chance(.5) ? width : 0);
      rays.push_back({Point3{} + origin, normalize(to + vec(width) - origin)});
    }
    return rays;
  }

  UniformNumbers random_;
  double size_;
  BlobStore blobs_;
};

}  // namespace tessera
