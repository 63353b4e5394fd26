#pragma once

#include <memory>
#include <span>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/math/color.h"
#include "renderer/shapes/ray.h"

namespace tessera {

class SurfaceSampler;
class Transform;

/// Work done while following rays; one per thread, added up per tile.
struct TraversalCounters {
  uint64_t node_visits = 0;
  uint64_t primitive_tests = 0;
};

/// A point of a surface in its shape's frame. The true surface passes through the box about `point`
/// of `point_error` on each axis (PBRT 4ed, 6.8), if not just where the ray meets it.
struct LocalSurface {
  Point3 point;
  Vec3 point_error;
  Normal3 geometric_normal;  ///< unit; out of a solid, or by counter-clockwise winding
  Normal3 shading_normal;    ///< unit; equals geometric_normal where nothing smooths it
  Vec3 smooth_shift;         ///< outward, to the surface that vertex normals stand for; or zero
  Vec2 uv;
  Vec3 dpdu, dpdv;  ///< derivatives of the point by uv; zero where there is no uv
  Vec2 second_uv;   ///< by a mesh's second texture coordinates, where has_second_uv
  Vec3 second_dpdu, second_dpdv;
  Vec3 tangent, bitangent;  ///< along which normal maps lie; zero: dpdu and dpdv
  Color vertex_color = kWhite;
  double vertex_alpha = 1;
  bool has_vertex_color = false;
  bool has_second_uv = false;
  uint32_t material = 0;  ///< index into the shape's materials
  uint32_t instance = 0;  ///< in world space: whose shape it is
};

/// Shapes that are tested without a virtual call: what a test of them takes is less than the call.
enum class ShapeKind : uint8_t { sphere, plane, other };

/// A surface in its own frame. Immutable after construction; all calls may run on many threads.
class Shape {
 public:
  explicit Shape(ShapeKind kind = ShapeKind::other) : kind_(kind) {}
  virtual ~Shape() = default;
  ShapeKind kind() const { return kind_; }
  virtual Bounds3 bounds() const = 0;
  /// Replaces `hit` by a hit of this shape that is nearer, or equally near with a smaller primitive
  /// number, inside (ray.t_min, min(ray.t_max, hit.t)]; says whether it did. Leaves hit.instance.
  virtual bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const = 0;
  /// Whether anything is hit inside (ray.t_min, ray.t_max).
  virtual bool any_hit(const Ray& ray, TraversalCounters& counters) const {
    Hit hit;
    return closest_hit(ray, hit, counters);
  }
  /// closest_hit() of each ray, with the same results; as many hits as rays.
  virtual void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                            TraversalCounters& counters) const {
    for (size_t i = 0; i < rays.size(); ++i) closest_hit(rays[i], hits[i], counters);
  }
  /// any_hit() of at most 64 rays, a bit each.
  virtual uint64_t any_hits(std::span<const Ray> rays, TraversalCounters& counters) const {
    uint64_t hit = 0;
    for (size_t i = 0; i < rays.size(); ++i) hit |= uint64_t{any_hit(rays[i], counters)} << i;
    return hit;
  }
  /// Whether the two above are faster than a call a ray where the rays go much the same way.
  virtual bool takes_batches() const { return false; }
  /// Appends every hit inside (ray.t_min, ray.t_max), in any order and with instance 0; a hit may
  /// be appended twice. This default finds one primitive at each t, which suffices for shapes whose
  /// surfaces meet in edges alone.
  virtual void all_hits(const Ray& ray, std::vector<Hit>& hits, TraversalCounters& counters) const {
    Ray rest = ray;
    for (Hit hit; closest_hit(rest, hit, counters); hit = {}) {
      hit.instance = 0;
      hits.push_back(hit);
      rest.t_min = hit.t;
    }
  }
  /// How often the ray passes from front to back, less how often from back to front, at `hits`,
  /// which are all of its hits, each once; ray.cull is none.
  virtual int crossing_number(const Ray& ray, std::span<const Hit> hits) const;
  /// What lies at a hit that closest_hit reported for this ray.
  virtual LocalSurface surface(const Ray& ray, const Hit& hit) const = 0;
  virtual size_t primitive_count() const { return 1; }
  /// Chooses points of it as it stands in the world, for light that it emits. Null for shapes whose
  /// points cannot be chosen: then paths find their light by chance.
  virtual std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                             bool flip_normals) const;
  /// Points, at most kMostOutlinePoints, whose convex hull is about its own: of a round shape one
  /// that leaves out a hundredth of its radius at most. By default the corners of its box, which
  /// must be finite.
  virtual std::vector<Point3> outline() const;

 private:
  ShapeKind kind_;
};

}  // namespace tessera
