#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "renderer/math/rounding.h"
#include "renderer/shapes/ray.h"

namespace tessera {

// The watertight ray-triangle test of Woop, Benthin and Wald (JCGT 2(1), 2013), in double. Vertices
// are sheared so that the ray becomes the z axis; the sign of each edge function of the sheared
// vertices is exact, so a ray through a closed mesh hits at least one triangle. Every accelerator
// decides its hits here, or by the same operations in the same order.

/// What the test needs of a ray, computed once. Refers to the ray.
struct TriangleRay {
  int kx, ky, kz;     ///< axes after the permutation that makes z the longest and keeps the winding
  Point3 origin;      ///< permuted
  double sx, sy, sz;  ///< shear and scale
  double depth;       ///< the direction's length along z: metres per unit of t
  double t_min, t_max;
  const Ray& ray;

  explicit TriangleRay(const Ray& ray);
  /// False where the direction is zero or not finite, or the origin not finite: hits nothing.
  bool valid() const {
    return sx * 0 + sy * 0 + sz * 0 + (origin.x * 0 + origin.y * 0 + origin.z * 0) == 0;
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

inline TriangleRay::TriangleRay(const Ray& r) : t_min(r.t_min), t_max(r.t_max), ray(r) {
  // By tables, not by branches: directions are random, and each wrong guess costs as much as a
  // node.
  static constexpr uint8_t kAxes[6][2] = {{1, 2}, {2, 1}, {2, 0}, {0, 2}, {0, 1}, {1, 0}};
  const double d[3] = {r.direction.x, r.direction.y, r.direction.z};
  const double o[3] = {r.origin.x, r.origin.y, r.origin.z};
  const double x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
  static constexpr uint8_t kLongest[4] = {1, 0, 2, 2};
  kz = kLongest[(z > std::max(x, y) ? 2 : 0) + (x > y ? 1 : 0)];
  const int backward = d[kz] < 0 ? 1 : 0;
  kx = kAxes[2 * kz + backward][0];
  ky = kAxes[2 * kz + backward][1];
  origin = {o[kx], o[ky], o[kz]};
  depth = std::abs(d[kz]);
  sz = 1 / d[kz];
  sx = d[kx] * sz;
  sy = d[ky] * sz;
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
/// moved. PBRT's rays are of about unit length; ours of any, so that x and y are in metres where z
/// is in units of t.
inline double t_error(const TriangleRay& ray, const ShearedTriangle& s, double inverse_det) {
  const auto largest = [](double a, double b, double c) {
    return std::max(std::max(std::abs(a), std::abs(b)), std::abs(c));
  };
  const double max_x = largest(s.ax, s.bx, s.cx);
  const double max_y = largest(s.ay, s.by, s.cy);
  const double max_z = largest(s.az, s.bz, s.cz);
  const double max_e = largest(s.u, s.v, s.w);
  const double max_depth = max_z * ray.depth;
  const double delta_x = gamma(5) * (max_x + max_depth);
  const double delta_y = gamma(5) * (max_y + max_depth);
  const double delta_z = gamma(3) * max_z;
  const double delta_e = 2 * (gamma(2) * (max_x * max_y) + (delta_y * max_x + delta_x * max_y));
  return 3 * (gamma(3) * (max_e * max_z) + (delta_e * max_z + delta_z * max_e)) *
         std::abs(inverse_det);
}

/// Makes the edge functions accurate where one is zero: that may be a rounded zero, and then a
/// sliver far away would count as hit. False where their signs differ after all, or all are zero.
bool sharpen_edges(ShearedTriangle& s);
/// Decides on a hit whose t is known badly: rejects it where it may be behind the origin, else
/// moves t to where the ray is inside the triangle's box.
bool settle_uncertain_t(const TriangleRay& ray, const ShearedTriangle& s,
                        const std::array<Point3, 3>& corners, double error, double& t);

/// Of t, the largest error that leaves it as it is; more is settled by another way.
inline constexpr double kMostErrorOfT = 0x1p-30;

/// The rest of the test, for the few triangles whose edge functions do not differ in sign.
/// `corners()` gives the three vertices, where they are needed.
template <typename Corners>
inline bool finish_triangle(const TriangleRay& ray, ShearedTriangle& s, Corners&& corners,
                            TriangleHit& hit) {
  if (s.u == 0 || s.v == 0 || s.w == 0) [[unlikely]] {
    if (!sharpen_edges(s)) return false;
  }
  const double det = s.u + s.v + s.w;
  const Cull cull = ray.ray.cull;
  if (cull != Cull::none && (cull == Cull::back ? det < 0 : det > 0)) return false;
  const double inverse_det = 1 / det;
  double t = (s.u * s.az + s.v * s.bz + s.w * s.cz) * inverse_det;
  const double error = t_error(ray, s, inverse_det);
  if (!(error <= t * kMostErrorOfT)) [[unlikely]] {
    if (!settle_uncertain_t(ray, s, corners(), error, t)) return false;
  }
  if (!(t > ray.t_min && t < ray.t_max)) return false;
  hit = {t, s.v * inverse_det, s.w * inverse_det};
  return true;
}

/// Whether the ray hits the triangle inside (t_min, t_max).
inline bool intersect_triangle(const TriangleRay& ray, const Point3& a, const Point3& b,
                               const Point3& c, TriangleHit& hit) {
  ShearedTriangle s = shear(ray, a, b, c);
  const bool all_up = s.u >= 0 && s.v >= 0 && s.w >= 0;
  const bool all_down = s.u <= 0 && s.v <= 0 && s.w <= 0;
  if (!(all_up || all_down)) return false;
  return finish_triangle(
      ray, s,
      [&] {
        return std::array<Point3, 3>{a, b, c};
      },
      hit);
}

}  // namespace tessera
