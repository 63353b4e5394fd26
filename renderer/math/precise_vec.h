#pragma once

#include "renderer/math/vec.h"

namespace tessera {

/// A vector over a type of number more precise than double: for what double is held against.
template <typename Number>
struct PreciseVec {
  Number x{}, y{}, z{};

  PreciseVec() = default;
  PreciseVec(const Number& x_, const Number& y_, const Number& z_) : x(x_), y(y_), z(z_) {}
  PreciseVec(const Vec3& v) : x(v.x), y(v.y), z(v.z) {}
  PreciseVec(const Point3& p) : x(p.x), y(p.y), z(p.z) {}

  friend PreciseVec operator+(const PreciseVec& a, const PreciseVec& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend PreciseVec operator-(const PreciseVec& a, const PreciseVec& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend PreciseVec operator*(const PreciseVec& a, const Number& s) {
    return {a.x * s, a.y * s, a.z * s};
  }
  friend Number dot(const PreciseVec& a, const PreciseVec& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
  friend PreciseVec cross(const PreciseVec& a, const PreciseVec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
};

}  // namespace tessera
