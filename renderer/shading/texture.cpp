#include "renderer/shading/texture.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/shading/noise.h"

namespace tessera {

namespace {

TextureCoordinate sphere_map(const Vec3& normal) {
  return {{normal.x / 2 + 0.5, normal.y / 2 + 0.5, 0}, {}, {}};
}

TextureCoordinate coordinate_of(const Texture& texture, const TexturePoint& point) {
  TextureCoordinate c;
  switch (texture.mapping) {
    case TextureMapping::uv:
      c = point.uv;
      break;
    case TextureMapping::second_uv:
      c = point.second_uv;
      break;
    case TextureMapping::object:
      c = point.object;
      break;
    case TextureMapping::world:
      c = point.world;
      break;
    case TextureMapping::object_normal:
      c = sphere_map(point.object_normal);
      break;
    case TextureMapping::view_normal:
      c = sphere_map(point.view_normal);
      break;
  }
  if (texture.transform == Affine{}) return c;
  return {texture.transform(Point3{} + c.at) - Point3{}, texture.transform(c.a),
          texture.transform(c.b)};
}

/// The patch's extent along an axis.
double extent(const TextureCoordinate& c, int axis) {
  return std::sqrt(c.a[axis] * c.a[axis] + c.b[axis] * c.b[axis]);
}

double largest_extent(const TextureCoordinate& c) {
  return std::max({extent(c, 0), extent(c, 1), extent(c, 2)});
}

/// The integral from 0 to x of a wave that is 1 in even cells and -1 in odd ones.
double wave_integral(double x) {
  const double in_pair = x - 2 * std::floor(x / 2);
  return in_pair < 1 ? in_pair : 2 - in_pair;
}

/// The mean over `width` around x of that wave.
double wave_mean(double x, double width) {
  const double low = std::floor(x - width / 2), high = std::floor(x + width / 2);
  if (low == high || !(width < 1e9)) {
    if (!(width < 1e9)) return 0;
    return low - 2 * std::floor(low / 2) == 0 ? 1 : -1;
  }
  return (wave_integral(x + width / 2) - wave_integral(x - width / 2)) / width;
}

Texel checker(const Texture& texture, const TextureCoordinate& c, const TexturePoint& point,
              std::span<const Texture> all) {
  double wave = 1;
  const int axes =
      texture.mapping == TextureMapping::object || texture.mapping == TextureMapping::world ? 3 : 2;
  for (int axis = 0; axis < axes; ++axis) wave *= wave_mean(c.at[axis], extent(c, axis));
  const double even = (1 + wave) / 2;
  const auto side = [&](const TexturedColor& input) -> Texel {
    if (input.texture == kNoTexture) return {input.value, 1};
    const Texel texel = look_up(all[input.texture], point, all);
    return {input.value * texel.color, texel.alpha};
  };
  if (even == 1) return side(texture.even);
  if (even == 0) return side(texture.odd);
  const Texel a = side(texture.odd), b = side(texture.even);
  return {a.color * (1 - even) + b.color * even, a.alpha * (1 - even) + b.alpha * even};
}

/// A wave of frequency 1 under a patch of `width` fades to its mean.
double faded(double wave, double width) {
  const double share = std::clamp(2 - 2 * width, 0.0, 1.0);
  return 0.5 + (wave - 0.5) * share;
}

double noise_weight(const Texture& texture, const TextureCoordinate& c) {
  const Vec3 p = c.at * texture.frequency;
  const double width = largest_extent(c) * texture.frequency;
  switch (texture.noise) {
    case NoiseKind::perlin:
      return (1 + texture.strength * fractal_noise(p, texture.octaves, width)) / 2;
    case NoiseKind::turbulence:
      return texture.strength * turbulence(p, texture.octaves, width);
    case NoiseKind::marble: {
      const double turns = p.x + texture.strength * turbulence(p, texture.octaves, width);
      const double wave = portable::sin(2 * portable::kPi * (turns - std::floor(turns)));
      return faded((1 + wave) / 2, extent(c, 0) * texture.frequency);
    }
    case NoiseKind::wood:
      break;
  }
  const double rings = std::sqrt(p.x * p.x + p.z * p.z) +
                       texture.strength * fractal_noise(p, texture.octaves, width);
  return faded(rings - std::floor(rings), width);
}

Color ramp(const Texture& texture, double x) {
  const auto& at = texture.positions;
  const auto next = static_cast<size_t>(std::upper_bound(at.begin(), at.end(), x) - at.begin());
  if (next == 0) return texture.colors.front();
  if (next == at.size()) return texture.colors.back();
  const double weight = (x - at[next - 1]) / (at[next] - at[next - 1]);
  return mix(texture.colors[next - 1], texture.colors[next], weight);
}

}  // namespace

Texel look_up(const Texture& texture, const TexturePoint& point, std::span<const Texture> all) {
  const TextureCoordinate c = coordinate_of(texture, point);
  switch (texture.kind) {
    case TextureKind::image:
      // Coordinates grow upwards, rows of a picture downwards.
      return texture.image->lookup(c.at.x, 1 - c.at.y, {c.a.x, -c.a.y}, {c.b.x, -c.b.y});
    case TextureKind::checker:
      return checker(texture, c, point, all);
    case TextureKind::noise:
      return {mix(texture.low, texture.high, std::clamp(noise_weight(texture, c), 0.0, 1.0)), 1};
    case TextureKind::gradient:
      break;
  }
  return {ramp(texture, c.at.x), 1};
}

}  // namespace tessera
