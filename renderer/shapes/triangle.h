#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/math/rounding.h"
#include "renderer/shapes/ray.h"

namespace tessera {

// The watertight ray-triangle test of Woop, Benthin and Wald (JCGT 2(1), 2013), in double. Vertices
// are sheared so that the ray becomes the z axis; the sign of each edge function of the sheared
// vertices is exact, so a ray through a closed mesh hits at least one triangle. Every accelerator
// decides its hits here, or by the same operations in the same order.

/// What the test needs of a ray, computed once.
struct TriangleRay {
  int kx, ky, kz;     ///< axes after the permutation that makes z the longest and keeps the winding
  Point3 origin;      ///< permuted
  double sx, sy, sz;  ///< shear and scale
  double t_min, t_max;
  Cull cull;
  Point3 world_origin;
  Vec3 direction;

  explicit TriangleRay(const Ray& ray);
  /// False where the direction is zero or not finite, or the origin not finite: hits nothing.
  bool valid() const { return std::isfinite(sz) && std::isfinite(sx + sy) && finite_origin(); }

 private:
  bool finite_origin() const {
    return std::isfinite(origin.x) && std::isfinite(origin.y) && std::isfinite(origin.z);
  }
};

/// Sheared vertices and their edge functions u, v, w: twice the signed area opposite to each
/// vertex.
struct ShearedTriangle {
  double ax, ay, az, bx, by, bz, cx, cy, cz;
  double u, v, w;
};

struct TriangleHit {
  double t = 0;
  double u = 0, v = 0;  ///< barycentric weights of vertices 1 and 2
};

inline TriangleRay::TriangleRay(const Ray& ray)
    : t_min(ray.t_min),
      t_max(ray.t_max),
      cull(ray.cull),
      world_origin(ray.origin),
      direction(ray.direction) {
  const Vec3& d = ray.direction;
  kz = std::abs(d.x) > std::abs(d.y) ? 0 : 1;
  if (std::abs(d.z) > std::abs(d[kz])) kz = 2;
  kx = kz == 2 ? 0 : kz + 1;
  ky = kx == 2 ? 0 : kx + 1;
  if (d[kz] < 0) std::swap(kx, ky);
  origin = {ray.origin[kx], ray.origin[ky], ray.origin[kz]};
  sz = 1 / d[kz];
  sx = d[kx] / d[kz];
  sy = d[ky] / d[kz];
}

inline ShearedTriangle shear(const TriangleRay& ray, const Point3& a, const Point3& b,
                             const Point3& c) {
  ShearedTriangle s;
  const auto one = [&ray](const Point3& p, double& x, double& y, double& z) {
    const double dz = p[ray.kz] - ray.origin.z;
    x = (p[ray.kx] - ray.origin.x) - ray.sx * dz;
    y = (p[ray.ky] - ray.origin.y) - ray.sy * dz;
    z = ray.sz * dz;
  };
  one(a, s.ax, s.ay, s.az);
  one(b, s.bx, s.by, s.bz);
  one(c, s.cx, s.cy, s.cz);
  s.u = s.cx * s.by - s.cy * s.bx;
  s.v = s.ax * s.cy - s.ay * s.cx;
  s.w = s.bx * s.ay - s.by * s.ax;
  return s;
}

/// Bound on the error of t (PBRT 4ed, 6.8.7), relative to 1/|det|: the hit counts only if t is
/// above it. Else a ray that starts on a sliver could hit it again, however far its origin was
/// moved.
inline double t_error(const ShearedTriangle& s, double inverse_det) {
  const auto largest = [](double a, double b, double c) {
    return std::max(std::max(std::abs(a), std::abs(b)), std::abs(c));
  };
  const double max_x = largest(s.ax, s.bx, s.cx);
  const double max_y = largest(s.ay, s.by, s.cy);
  const double max_z = largest(s.az, s.bz, s.cz);
  const double max_e = largest(s.u, s.v, s.w);
  const double delta_x = gamma(5) * (max_x + max_z);
  const double delta_y = gamma(5) * (max_y + max_z);
  const double delta_z = gamma(3) * max_z;
  const double delta_e = 2 * (gamma(2) * (max_x * max_y) + (delta_y * max_x + delta_x * max_y));
  return 3 * (gamma(3) * (max_e * max_z) + (delta_e * max_z + delta_z * max_e)) *
         std::abs(inverse_det);
}

/// The rest of the test, for the few triangles whose edge functions do not differ in sign.
bool finish_triangle(const TriangleRay& ray, const Point3& a, const Point3& b, const Point3& c,
                     ShearedTriangle& s, TriangleHit& hit);

/// Whether the ray hits the triangle inside (t_min, t_max).
inline bool intersect_triangle(const TriangleRay& ray, const Point3& a, const Point3& b,
                               const Point3& c, TriangleHit& hit) {
  ShearedTriangle s = shear(ray, a, b, c);
  const bool all_up = s.u >= 0 && s.v >= 0 && s.w >= 0;
  const bool all_down = s.u <= 0 && s.v <= 0 && s.w <= 0;
  return (all_up || all_down) && finish_triangle(ray, a, b, c, s, hit);
}

}  // namespace tessera
