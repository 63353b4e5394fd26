#pragma once

#include <array>
#include <cmath>

#include "renderer/math/quartic.h"
#include "renderer/shapes/ray.h"
#include "renderer/shapes/triangle.h"

namespace tessera::plain {

// The usual tests, in single or double precision: what `tessera bench precision` holds ours
// against. Each gives the smallest positive t, or 0.

template <typename Real>
struct Vec {
  Real x, y, z;
  explicit Vec(const Vec3& v)
      : x(static_cast<Real>(v.x)), y(static_cast<Real>(v.y)), z(static_cast<Real>(v.z)) {}
  explicit Vec(const Point3& p) : Vec(p - Point3{}) {}
  Vec(Real x_, Real y_, Real z_) : x(x_), y(y_), z(z_) {}
  Vec operator-(const Vec& o) const { return {x - o.x, y - o.y, z - o.z}; }
  Vec operator+(const Vec& o) const { return {x + o.x, y + o.y, z + o.z}; }
  Vec operator*(Real s) const { return {x * s, y * s, z * s}; }
  Real dot(const Vec& o) const { return x * o.x + y * o.y + z * o.z; }
  Vec cross(const Vec& o) const {
    return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x};
  }
};

/// Moller and Trumbore 1997.
template <typename Real>
double moller_trumbore(const std::array<Point3, 3>& c, const Ray& ray) {
  const Vec<Real> o(ray.origin), d(ray.direction), a(c[0]);
  const Vec<Real> e1 = Vec<Real>(c[1]) - a, e2 = Vec<Real>(c[2]) - a, p = d.cross(e2);
  const Real det = e1.dot(p);
  if (det == 0) return 0;
  const Real inverse = 1 / det;
  const Vec<Real> to = o - a, q = to.cross(e1);
  const Real u = to.dot(p) * inverse, v = d.dot(q) * inverse;
  if (!(u >= 0 && v >= 0 && u + v <= 1)) return 0;
  const Real t = e2.dot(q) * inverse;
  return t > 0 ? static_cast<double>(t) : 0;
}

/// Woop, Benthin and Wald 2013, without its second look in double and without a bound on t.
template <typename Real>
double woop(const std::array<Point3, 3>& c, const Ray& ray) {
  const TriangleRay axes(ray);
  const Real dz = static_cast<Real>(ray.direction[axes.kz]);
  const Real sx = static_cast<Real>(ray.direction[axes.kx]) / dz;
  const Real sy = static_cast<Real>(ray.direction[axes.ky]) / dz, sz = 1 / dz;
  std::array<Real, 3> x, y, z;
  for (size_t i = 0; i < 3; ++i) {
    const auto from_origin = [&](int axis) {
      return static_cast<Real>(c[i][axis]) - static_cast<Real>(ray.origin[axis]);
    };
    const Real depth = from_origin(axes.kz);
    x[i] = from_origin(axes.kx) - sx * depth;
    y[i] = from_origin(axes.ky) - sy * depth;
    z[i] = sz * depth;
  }
  const Real u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2];
  const Real w = x[1] * y[0] - y[1] * x[0], det = u + v + w;
  if (((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) || det == 0) return 0;
  const Real t = (u * z[0] + v * z[1] + w * z[2]) / det;
  return t > 0 ? static_cast<double>(t) : 0;
}

template <typename Real>
double nearer_root(Real t0, Real t1) {
  return static_cast<double>(t0 > 0 ? t0 : t1 > 0 ? t1 : 0);
}

/// b^2 - a c from the textbook, about a unit sphere at the origin.
template <typename Real>
double textbook_sphere(const Ray& ray) {
  const Vec<Real> o(ray.origin), d(ray.direction);
  const Real a = d.dot(d), b = o.dot(d), c = o.dot(o) - 1;
  const Real discriminant = b * b - a * c;
  if (!(discriminant >= 0)) return 0;
  const Real root = std::sqrt(discriminant);
  return nearer_root((-b - root) / a, (-b + root) / a);
}

/// Haines, Guenther and Akenine-Moller 2019 (Ray Tracing Gems 7).
template <typename Real>
double gems_sphere(const Ray& ray) {
  const Vec<Real> o(ray.origin), d(ray.direction);
  const Real a = d.dot(d), b = -o.dot(d);
  const Vec<Real> nearest = o + d * (b / a);
  const Real discriminant = 1 - nearest.dot(nearest);
  if (!(discriminant >= 0)) return 0;
  const Real c = o.dot(o) - 1, q = b + std::copysign(std::sqrt(a * discriminant), b);
  const Real t0 = c / q, t1 = q / a;
  return t0 < t1 ? nearer_root(t0, t1) : nearer_root(t1, t0);
}

/// The quartic of a torus about the y axis, major radius 1, solved from the ray's own origin or
/// from the point of the line that is nearest to the centre.
inline double quartic_torus(double minor, const Ray& ray, bool moved) {
  const Vec3& d = ray.direction;
  const double dd = dot(d, d), shift = moved ? -dot(ray.origin - Point3{}, d) / dd : 0;
  const Vec3 p = ray.at(shift) - Point3{};
  const double k = dot(p, p) + 1 - minor * minor, pd = dot(p, d);
  std::array<double, 4> roots;
  const int n =
      solve_quartic({k * k - 4 * (p.x * p.x + p.z * p.z), 4 * k * pd - 8 * (p.x * d.x + p.z * d.z),
                     2 * k * dd + 4 * pd * pd - 4 * (d.x * d.x + d.z * d.z), 4 * pd * dd, dd * dd},
                    roots);
  for (int i = 0; i < n; ++i)
    if (roots[static_cast<size_t>(i)] + shift > 0) return roots[static_cast<size_t>(i)] + shift;
  return 0;
}

}  // namespace tessera::plain
