#include "renderer/shapes/box.h"

#include "renderer/math/rounding.h"
#include "renderer/shapes/triangle_sampler.h"

namespace tessera {
namespace {

struct Crossing {
  double t;
  uint32_t face = 6;
};

/// Where the ray enters and leaves, with the faces; of equal ones the smaller number. False for a
/// miss. The sign of (side - origin) is exact, so an origin just outside of a face never meets it.
bool cross_box(const Bounds3& box, const Ray& ray, Crossing& enter, Crossing& leave) {
  enter = {-Bounds3::kInfinity};
  leave = {Bounds3::kInfinity};
  // Which way a ray goes, and which side it meets first, is a matter of chance: without branches.
  const Point3* const ends[2] = {&box.min, &box.max};
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0) {
      if (!(o >= box.min[axis] && o <= box.max[axis])) return false;
      continue;
    }
    const uint32_t down = d < 0, first = 2 * static_cast<uint32_t>(axis);
    const double t_in = ((*ends[down])[axis] - o) / d, t_out = ((*ends[1 - down])[axis] - o) / d;
    const bool enters = t_in > enter.t, leaves = t_out < leave.t;
    enter.t = enters ? t_in : enter.t;
    enter.face = enters ? first + down : enter.face;
    leave.t = leaves ? t_out : leave.t;
    leave.face = leaves ? first + 1 - down : leave.face;
  }
  return enter.face < 6 && enter.t <= leave.t;
}

/// Two triangles a face, counter-clockwise seen from outside.
void add_faces(const Bounds3& extent, TriangleSet& triangles) {
  const Vec3 size = extent.diagonal();
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    Vec3 across, u, v;
    across[axis] = size[axis];
    u[next] = size[next];
    v[last] = size[last];
    const auto add = [&](const Point3& p, const Vec3& s, const Vec3& t) {
      triangles.add({p, p + s, p + s + t});
      triangles.add({p, p + s + t, p + t});
    };
    add(extent.min + across, u, v);
    add(extent.min, v, u);
  }
}

}  // namespace

bool Box::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  ++counters.primitive_tests;
  Crossing enter, leave;
  if (!cross_box(extent_, ray, enter, leave)) return false;
  const Crossing crossings[2] = {enter, leave};
  for (int i = 0; i < 2; ++i) {
    // Entering shows the front, leaving the back.
    if (ray.cull == (i == 0 ? Cull::front : Cull::back)) continue;
    const Crossing& at = crossings[i];
    if (!(at.t > ray.t_min && at.t < ray.t_max)) continue;
    if (at.t > hit.t || (at.t == hit.t && at.face >= hit.primitive)) return false;
    hit = {at.t, 0, 0, hit.instance, at.face};
    return true;
  }
  return false;
}

LocalSurface Box::surface(const Ray& ray, const Hit& hit) const {
  LocalSurface s;
  const int axis = static_cast<int>(hit.primitive / 2);
  const bool upper = hit.primitive % 2 == 1;
  const Point3 p = ray.at(hit.t);
  for (int a = 0; a < 3; ++a) {
    s.point[a] = std::min(std::max(p[a], extent_.min[a]), extent_.max[a]);
    if (a == axis) s.point[a] = upper ? extent_.max[a] : extent_.min[a];
  }
  Vec3 n, right, up{0, 1, 0};
  n[axis] = upper ? 1 : -1;
  if (axis == 1) up = {0, 0, upper ? -1.0 : 1.0};
  right = cross(up, n);
  s.geometric_normal = s.shading_normal = to_normal(n);
  const Vec3 size = extent_.diagonal();
  const auto along = [&](const Vec3& direction, double& coordinate, Vec3& derivative) {
    for (int a = 0; a < 3; ++a) {
      if (direction[a] == 0) continue;
      const double f = size[a] > 0 ? (s.point[a] - extent_.min[a]) / size[a] : 0;
      coordinate = direction[a] > 0 ? f : 1 - f;
      derivative = direction * size[a];
    }
  };
  along(right, s.uv.x, s.dpdu);
  along(up, s.uv.y, s.dpdv);
  return s;
}

std::unique_ptr<const SurfaceSampler> Box::make_sampler(const Transform& world_from_object,
                                                        bool flip_normals) const {
  const auto triangles = std::make_shared<TriangleSet>();
  add_faces(extent_, *triangles);
  return make_triangle_sampler(triangles, world_from_object, flip_normals);
}

}  // namespace tessera
