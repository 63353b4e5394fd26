#include "renderer/camera/lens.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

/// Keeps neighbours together, so that well-spread numbers give well-spread points (Shirley and Chiu
/// 1997).
Vec2 concentric_disc(const Vec2& u) {
  const double a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  constexpr double kQuarter = portable::kPi / 4;
  const bool a_leads = std::abs(a) > std::abs(b);
  const double radius = a_leads ? a : b;
  const double angle = a_leads ? kQuarter * (b / a) : 2 * kQuarter - kQuarter * (a / b);
  return {radius * portable::cos(angle), radius * portable::sin(angle)};
}

Vec2 corner(uint32_t number, uint32_t count) {
  const double angle = 2 * portable::kPi * number / count;
  return {-portable::cos(angle), -portable::sin(angle)};
}

/// One of the triangles between the centre and a side, then a point of it.
Vec2 polygon(uint32_t blades, Vec2 u) {
  const double scaled = u.x * blades;
  const uint32_t side = std::min(static_cast<uint32_t>(scaled), blades - 1);
  u.x = scaled - side;
  if (u.x + u.y > 1) u = {1 - u.x, 1 - u.y};
  const Vec2 a = corner(side, blades), b = corner(side + 1, blades);
  return {u.x * a.x + u.y * b.x, u.x * a.y + u.y * b.y};
}

/// Box and Muller 1958.
Vec2 gaussian(const Vec2& u) {
  const double radius = std::sqrt(-2 * portable::log(1 - u.x));
  const double angle = 2 * portable::kPi * u.y;
  return {radius * portable::cos(angle), radius * portable::sin(angle)};
}

}  // namespace

Vec2 sample_lens(LensShape shape, uint32_t blades, const Vec2& u) {
  switch (shape) {
    case LensShape::circle:
      break;
    case LensShape::polygon:
      return polygon(blades, u);
    case LensShape::square:
      return {2 * u.x - 1, 2 * u.y - 1};
    case LensShape::gaussian:
      return gaussian(u);
    case LensShape::line:
      return {u.x - u.y, 0};
  }
  return concentric_disc(u);
}

}  // namespace tessera
