#include "renderer/shading/background.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

Color ring_color(const std::vector<Background::Ring>& rings, double angle) {
  size_t next = 1;
  while (next < rings.size() && rings[next].angle < angle) ++next;
  if (next >= rings.size()) return rings.back().color;
  const Background::Ring& a = rings[next - 1];
  const Background::Ring& b = rings[next];
  return mix(a.color, b.color, (angle - a.angle) / (b.angle - a.angle));
}

Color rings_radiance(const Background& background, const Vec3& d) {
  const double from_zenith = portable::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y);
  const auto& ground = background.ground_rings;
  if (ground.size() > 1 && portable::kPi - from_zenith <= ground.back().angle) {
    return ring_color(ground, portable::kPi - from_zenith);
  }
  return background.sky_rings.empty() ? kBlack : ring_color(background.sky_rings, from_zenith);
}

// What looks pictures up stays out of the way of the plain colours.
[[gnu::noinline]] Color panorama_radiance(const Background& background, const Vec3& d) {
  const Vec2 place = place_in_panorama(background.kind, background.angle, d);
  return background.panorama_at(place.x, place.y);
}

/// The picture of the face that `d` points to over `behind`.
[[gnu::noinline]] Color over_cube(const Background& background, const Vec3& d,
                                  const Color& behind) {
  const Vec3 size = abs(d);
  const double most = max_component(size);
  if (!(most > 0)) return behind;
  const Vec3 p = d / most;
  Background::Face face;
  double right, down;
  if (size.z == most) {
    face = d.z < 0 ? Background::front : Background::back;
    right = d.z < 0 ? p.x : -p.x, down = -p.y;
  } else if (size.x == most) {
    face = d.x > 0 ? Background::right : Background::left;
    right = d.x > 0 ? p.z : -p.z, down = -p.y;
  } else {
    face = d.y > 0 ? Background::top : Background::bottom;
    right = p.x, down = d.y > 0 ? -p.z : p.z;
  }
  const ImageTexture* const picture = background.cube[face].get();
  if (!picture) return behind;
  // Up to the middle of the outer texels: beyond the edge comes another picture.
  const auto inside = [](double at, uint32_t texels) {
    const double half = 0.5 / texels;
    return std::clamp((at + 1) / 2, half, 1 - half);
  };
  const Texel texel = picture->lookup(inside(right, picture->settings().width),
                                      inside(down, picture->settings().height));
  const Color color = without_negative(texel.color);
  // Colours multiplied by alpha may be light that covers nothing.
  if (texel.alpha == 0 && picture->settings().is_associated) return behind + color;
  return mix(behind, color, texel.alpha);
}

/// The share of light from every direction that a light is in: the sum over lights.
double glow_towards(const Point3& origin, const Vec3& d, std::span<const Light> lights) {
  double sum = 0;
  for (const Light& light : lights) {
    const Vec3 to_light = light.is_placed() ? light.position - origin : -light.direction;
    if (length_squared(to_light) > 0) sum += std::max(0.0, dot(d, normalize(to_light)));
  }
  return sum;
}

}  // namespace

Color Background::radiance(const Point3& origin, const Vec3& d,
                           std::span<const Light> lights) const {
  Color color = sky;
  if (kind != BackgroundKind::solid || has_cube) {
    const Vec3 turned{dot(rotation[0], d), dot(rotation[1], d), dot(rotation[2], d)};
    switch (kind) {
      case BackgroundKind::gradient_linear:
        color = mix(ground, sky, (turned.y + 1) / 2);
        break;
      case BackgroundKind::gradient_absolute:
        color = mix(ground, sky, std::min(std::abs(turned.y), 1.0));
        break;
      case BackgroundKind::panorama_equirectangular:
      case BackgroundKind::panorama_equal_area:
        color = panorama_radiance(*this, turned);
        break;
      case BackgroundKind::rings:
        color = rings_radiance(*this, turned);
        break;
      case BackgroundKind::sun_and_sky:
        color = daylight->radiance(turned);
        if (has_sun_disc) color += daylight->sun_radiance(turned);
        break;
      case BackgroundKind::solid:
        break;
    }
    if (has_cube) color = over_cube(*this, turned, color);
  }
  if (transparency != 0) color = color * (1 - transparency);
  if (glow != 0) color += kWhite * (glow * glow_towards(origin, d, lights));
  return color;
}

double Fog::clearness(double distance) const {
  if (kind == FogKind::none) return 1;
  if (distance >= visibility_range) return 0;
  const double left = visibility_range - distance;
  return kind == FogKind::linear ? left / visibility_range : portable::exp(-distance / left);
}

}  // namespace tessera
