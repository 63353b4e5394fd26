#pragma once

#include <algorithm>
#include <cmath>

namespace tessera {

/// A direction or displacement. Doubles throughout: single precision is for culling alone.
struct Vec3 {
  double x = 0, y = 0, z = 0;
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

/// A place. Differences of points are vectors; points do not add.
struct Point3 {
  double x = 0, y = 0, z = 0;
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  friend bool operator==(const Point3&, const Point3&) = default;
};

/// A surface normal: transforms by the inverse transpose.
struct Normal3 {
  double x = 0, y = 0, z = 0;
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  explicit operator Vec3() const { return {x, y, z}; }
  friend bool operator==(const Normal3&, const Normal3&) = default;
};

struct Vec2 {
  double x = 0, y = 0;
  friend bool operator==(const Vec2&, const Vec2&) = default;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(const Vec3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3 operator*(double s, const Vec3& a) { return a * s; }
inline Vec3 operator/(const Vec3& a, double s) { return {a.x / s, a.y / s, a.z / s}; }

inline Point3 operator+(const Point3& p, const Vec3& v) {
  return {p.x + v.x, p.y + v.y, p.z + v.z};
}
inline Point3 operator-(const Point3& p, const Vec3& v) {
  return {p.x - v.x, p.y - v.y, p.z - v.z};
}
inline Vec3 operator-(const Point3& a, const Point3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Vec3 to_vec(const Point3& p) { return {p.x, p.y, p.z}; }
inline Point3 to_point(const Vec3& v) { return {v.x, v.y, v.z}; }

inline Normal3 operator-(const Normal3& n) { return {-n.x, -n.y, -n.z}; }
inline Normal3 to_normal(const Vec3& v) { return {v.x, v.y, v.z}; }

inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double dot(const Normal3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double dot(const Vec3& a, const Normal3& b) { return dot(b, a); }
inline double dot(const Normal3& a, const Normal3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length_squared(const Vec3& v) { return dot(v, v); }
inline double length(const Vec3& v) { return std::sqrt(dot(v, v)); }
inline double distance(const Point3& a, const Point3& b) { return length(a - b); }
/// Between these the square of a length is as exact as any: what underflows of its parts' squares
/// is too small to matter, and nothing overflows.
inline constexpr double kLeastSafeSquare = 1e-280, kMostSafeSquare = 1e280;
/// normalize() where the square of the length is not between them.
Vec3 normalize_extreme(const Vec3& v);
/// Unit vector along `v`, which must not be zero; safe from overflow and underflow.
inline Vec3 normalize(const Vec3& v) {
  const double squared = dot(v, v);
  if (!(squared > kLeastSafeSquare && squared < kMostSafeSquare)) [[unlikely]]
    return normalize_extreme(v);
  return v / std::sqrt(squared);
}
inline Normal3 normalize(const Normal3& n) { return to_normal(normalize(static_cast<Vec3>(n))); }
inline Vec3 abs(const Vec3& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
/// The sum of the parts' sizes: what rounding moves a place by goes with it. Added up from x on.
inline double l1_norm(const Vec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }
inline double max_component(const Vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
/// Mirrors `v` about `n`: the way a ray leaves a mirror, given the way it came.
inline Vec3 reflect(const Vec3& v, const Vec3& n) { return v - n * (2 * dot(v, n)); }

}  // namespace tessera
