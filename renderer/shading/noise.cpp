#include "renderer/shading/noise.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

uint32_t lattice_hash(int64_t x, int64_t y, int64_t z) {
  uint64_t v = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u;
  v = (v ^ (v >> 32)) + static_cast<uint64_t>(y) * 0xbf58476d1ce4e5b9u;
  v = (v ^ (v >> 29)) + static_cast<uint64_t>(z) * 0x94d049bb133111ebu;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
  return static_cast<uint32_t>(v >> 40);
}

/// The offset's product with one of the twelve edge middles of a cube, four of them twice.
double corner_value(uint32_t hash, const Vec3& offset) {
  const uint32_t edge = hash & 15;
  const double first = edge < 8 ? offset.x : offset.y;
  const double second = edge < 4 ? offset.y : edge == 12 || edge == 14 ? offset.x : offset.z;
  return (edge & 1 ? -first : first) + (edge & 2 ? -second : second);
}

double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

double lerp(double a, double b, double t) { return a + t * (b - a); }

/// How much is left of features of frequency 1 under a patch of `width`: all to half of a feature,
/// none from a whole one.
double visible_share(double width) { return std::clamp(2 - 2 * width, 0.0, 1.0); }

}  // namespace

double gradient_noise(const Vec3& p) {
  // Beyond this there are no digits between lattice points.
  constexpr double kFar = 0x1p50;
  if (!(max_component(abs(p)) < kFar)) return 0;
  const Vec3 low{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  const Vec3 in_cell = p - low;
  const auto ix = static_cast<int64_t>(low.x), iy = static_cast<int64_t>(low.y),
             iz = static_cast<int64_t>(low.z);
  const double u = fade(in_cell.x), v = fade(in_cell.y), w = fade(in_cell.z);
  double layer[2];
  for (int k = 0; k < 2; ++k) {
    double row[2];
    for (int j = 0; j < 2; ++j) {
      double corner[2];
      for (int i = 0; i < 2; ++i) {
        corner[i] = corner_value(lattice_hash(ix + i, iy + j, iz + k),
                                 in_cell - Vec3{double(i), double(j), double(k)});
      }
      row[j] = lerp(corner[0], corner[1], u);
    }
    layer[k] = lerp(row[0], row[1], v);
  }
  return lerp(layer[0], layer[1], w);
}

double fractal_noise(const Vec3& p, uint32_t octaves, double width) {
  double sum = 0, scale = 1;
  for (uint32_t i = 0; i < octaves; ++i, scale *= 2) {
    const double share = visible_share(width * scale);
    if (share == 0) break;
    sum += share / scale * gradient_noise(p * scale);
  }
  return sum;
}

double turbulence(const Vec3& p, uint32_t octaves, double width) {
  constexpr double kMean = 0.2202;  // of |noise|, measured over 2e7 points
  double sum = 0, scale = 1;
  for (uint32_t i = 0; i < octaves; ++i, scale *= 2) {
    const double share = visible_share(width * scale);
    const double value = share > 0 ? std::abs(gradient_noise(p * scale)) : 0;
    sum += lerp(kMean, value, share) / scale;
  }
  return sum;
}

}  // namespace tessera
