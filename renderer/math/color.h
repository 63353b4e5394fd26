#pragma once

#include <algorithm>

namespace tessera {

/// Linear RGB radiance or reflectance.
struct Color {
  double r = 0, g = 0, b = 0;
  friend bool operator==(const Color&, const Color&) = default;
  Color& operator+=(const Color& o) {
    r += o.r, g += o.g, b += o.b;
    return *this;
  }
};

inline constexpr Color kBlack{0, 0, 0};
inline constexpr Color kWhite{1, 1, 1};

inline Color operator+(const Color& a, const Color& b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
inline Color operator-(const Color& a, const Color& b) { return {a.r - b.r, a.g - b.g, a.b - b.b}; }
inline Color operator*(const Color& a, const Color& b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
inline Color operator*(const Color& a, double s) { return {a.r * s, a.g * s, a.b * s}; }
inline Color operator*(double s, const Color& a) { return a * s; }
inline Color mix(const Color& a, const Color& b, double weight_of_b) {
  return a * (1 - weight_of_b) + b * weight_of_b;
}
inline bool is_black(const Color& c) { return c.r == 0 && c.g == 0 && c.b == 0; }
/// Negative light is none.
inline Color without_negative(const Color& c) {
  return {std::max(c.r, 0.0), std::max(c.g, 0.0), std::max(c.b, 0.0)};
}
inline double max_component(const Color& c) { return std::max(c.r, std::max(c.g, c.b)); }

}  // namespace tessera
