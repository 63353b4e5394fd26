#include "bench/error/closed_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace tessera {
namespace {

/// Of the floor and of the lights, as in scenes/generate/accuracy_scenes.cpp.
constexpr double kAlbedo = .8, kLamp = 5;

struct Point2 {
  double x, y;
};

/// Share of the square [x0, x0 + side] x [y0, y0 + side] where (p - point) . normal >= 0, by
/// clipping (Sutherland and Hodgman 1974).
double covered_share(double x0, double y0, double side, Point2 point, Point2 normal) {
  const std::array<Point2, 4> corners{
      {{x0, y0}, {x0 + side, y0}, {x0 + side, y0 + side}, {x0, y0 + side}}};
  const auto distance = [&](const Point2& p) {
    return (p.x - point.x) * normal.x + (p.y - point.y) * normal.y;
  };
  std::vector<Point2> inside;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Point2 a = corners[i], b = corners[(i + 1) % corners.size()];
    const double da = distance(a), db = distance(b);
    if (da >= 0) inside.push_back(a);
    if ((da >= 0) != (db >= 0)) {
      const double t = da / (da - db);
      inside.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
    }
  }
  double twice_area = 0;
  for (size_t i = 0; i < inside.size(); ++i) {
    const Point2 a = inside[i], b = inside[(i + 1) % inside.size()];
    twice_area += a.x * b.y - a.y * b.x;
  }
  return std::abs(twice_area) / 2 / (side * side);
}

/// Irradiance from a sphere that is all above the horizon.
double sphere_irradiance(double x, double z) {
  constexpr double kX = 1.5, kY = .8, kZ = .2, kRadius = .4;
  const double square = (kX - x) * (kX - x) + kY * kY + (kZ - z) * (kZ - z);
  return std::numbers::pi * kLamp * kRadius * kRadius / square * (kY / std::sqrt(square));
}

/// Irradiance from a rectangle parallel to the floor at height h whose one corner is right above
/// and that spans a and b; negative where one of them is.
double corner_irradiance(double a, double b, double h) {
  a /= h, b /= h;
  const double u = std::sqrt(1 + a * a), v = std::sqrt(1 + b * b);
  return kLamp / 2 * (a / u * std::atan(b / u) + b / v * std::atan(a / v));
}

double rectangle_irradiance(double x, double z) {
  constexpr double kX0 = 1.2, kX1 = 2.2, kZ0 = -.5, kZ1 = .3, kHeight = .6;
  return corner_irradiance(kX1 - x, kZ1 - z, kHeight) -
         corner_irradiance(kX0 - x, kZ1 - z, kHeight) -
         corner_irradiance(kX1 - x, kZ0 - z, kHeight) +
         corner_irradiance(kX0 - x, kZ0 - z, kHeight);
}

/// Irradiance from a white sky, half of it behind an endless wall of height 1 at x = 0.
double wall_irradiance(double x) { return std::numbers::pi / 2 * (1 + x / std::sqrt(x * x + 1)); }

Picture grey(int width, int height) {
  return {width, height, std::vector<float>(3 * static_cast<size_t>(width) * height)};
}

/// `value` of each pixel's square; the picture shows [left, left + 2] x [-1, 1], which only a
/// square one can.
template <typename Value>
std::optional<Picture> of_squares(int size, int height, double left, const Value& value) {
  if (size != height) return std::nullopt;
  Picture out = grey(size, height);
  const double side = 2. / size;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < size; ++column)
      std::fill_n(out.values.begin() + 3 * (static_cast<std::ptrdiff_t>(row) * size + column), 3,
                  static_cast<float>(value(left + column * side, -1 + row * side, side)));
  return out;
}

/// The mean over each pixel of what the floor at (x, z) reflects of `irradiance`, which is smooth.
template <typename Irradiance>
std::optional<Picture> floor_picture(int width, int height, double left,
                                     const Irradiance& irradiance) {
  return of_squares(width, height, left, [&](double x, double z, double side) {
    constexpr int kParts = 8;
    double sum = 0;
    for (int i = 0; i < kParts; ++i)
      for (int j = 0; j < kParts; ++j)
        sum += irradiance(x + side * (i + .5) / kParts, z + side * (j + .5) / kParts);
    return kAlbedo / std::numbers::pi * sum / (kParts * kParts);
  });
}

}  // namespace

std::optional<Picture> closed_form(std::string_view scene, int width, int height) {
  if (scene == "edge") {
    return of_squares(width, height, -1, [](double x, double top, double side) {
      return covered_share(x, -top - side, side, {.0123, .0217}, {.8, .6});
    });
  }
  if (scene == "furnace") {
    Picture out = grey(width, height);
    std::fill(out.values.begin(), out.values.end(), 1.F);
    return out;
  }
  if (scene == "sphere-light") return floor_picture(width, height, -1, sphere_irradiance);
  if (scene == "rectangle-light") return floor_picture(width, height, -1, rectangle_irradiance);
  if (scene == "sky-wall")
    return floor_picture(width, height, .05, [](double x, double) { return wall_irradiance(x); });
  return std::nullopt;
}

}  // namespace tessera
