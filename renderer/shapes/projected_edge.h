#pragma once

#include "renderer/shapes/triangle.h"

namespace tessera {

// A vertex as the watertight triangle test sees it: sheared so that the ray is the z axis. The same
// operations as in triangle.h, so that whatever shares a vertex shares its projection bit for bit.

struct ProjectedVertex {
  double x = 0, y = 0, z = 0;  ///< z is the ray's parameter at the vertex's depth
};

inline ProjectedVertex project(const TriangleRay& ray, const Point3& p) {
  const double dz = p[ray.kz] - ray.origin.z;
  return {(p[ray.kx] - ray.origin.x) - ray.sx * dz, (p[ray.ky] - ray.origin.y) - ray.sy * dz,
          ray.sz * dz};
}

/// Twice the area of (ray, a, b); positive where the edge passes it counter-clockwise seen along
/// the ray. Exact in sign, and in being 0, as rounding keeps order.
inline double edge_function(const ProjectedVertex& a, const ProjectedVertex& b) {
  const double left = a.y * b.x, right = a.x * b.y;
  return left != right ? left - right : difference_of_products(a.y, b.x, a.x, b.y);
}

/// The sign of edge_function, never 0 but for coinciding vertices: an edge right on the ray is
/// taken on the side on which it is when the ray moves by (e, e^2) for an endlessly small e. Of two
/// faces on either side of an edge exactly one is then crossed (Edelsbrunner, Muecke 1990).
inline int edge_side(const ProjectedVertex& a, const ProjectedVertex& b) {
  const double value = edge_function(a, b);
  if (value != 0) return value > 0 ? 1 : -1;
  if (a.y != b.y) return b.y > a.y ? 1 : -1;
  if (a.x != b.x) return a.x > b.x ? 1 : -1;
  return 0;
}

}  // namespace tessera
