#pragma once

#include <array>
#include <memory>
#include <vector>

#include "renderer/math/transform.h"
#include "renderer/math/vec.h"
#include "renderer/shapes/shape.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// A point of a surface in world space.
struct SurfaceSample {
  Point3 point;
  Vec3 point_error;  ///< bound on each axis
  Vec3 normal;       ///< unit; where the shape's front is
};

/// Chooses points of a surface as they are seen from elsewhere, for light that comes from it.
/// Immutable after construction; thread-safe; does not allocate.
class SurfaceSampler {
 public:
  virtual ~SurfaceSampler() = default;
  /// The point that `u`, uniform in [0, 1)^2, chooses, and the density of its direction per
  /// steradian seen from `from`; 0 where there is none to choose.
  virtual double sample(const Point3& from, const Vec2& u, SurfaceSample& sample) const = 0;
  /// The density with which sample() chooses `there`, a point of the surface with its normal.
  virtual double density(const Point3& from, const Point3& there, const Vec3& normal) const = 0;
  virtual double area() const = 0;     ///< square metres, > 0
  virtual Bounds3 bounds() const = 0;  ///< about, rounding apart
  /// Whether all of it lies in one plane, through `at` across `normal`, which shows the front.
  virtual bool is_flat(Point3& /*at*/, Vec3& /*normal*/) const { return false; }
};

/// For a shape as it stands in the world: spheres that stay spheres by the cone in which they are
/// seen, rectangles by solid angle (Urena et al. 2013, "An Area-Preserving Parametrization for
/// Spherical Rectangles") where they are near, others about so, by densities that are linear along
/// both edges; discs, polygons, boxes, ellipsoids, cylinders, cones and tori by area.
/// Null for any other shape.
std::unique_ptr<const SurfaceSampler> make_surface_sampler(const Shape& shape,
                                                           const Transform& world_from_object,
                                                           bool flip_normals);
/// Triangles to choose from by area, in their own frame. Immutable; shared by all places where they
/// stand.
class TriangleSet {
 public:
  /// Those of `mesh` that have an area and whose face material is `material`.
  static TriangleSet of(const TriangleMesh& mesh, uint32_t material);
  void add(const Point3& a, const Point3& b, const Point3& c);
  bool empty() const { return corners_.empty(); }
  double area() const { return sums_.empty() ? 0 : sums_.back(); }
  const Bounds3& bounds() const { return bounds_; }
  using Corners = std::array<Point3, 3>;
  /// The one that `u.x` chooses; what is left of the number goes back into it. Not of an empty set.
  const Corners& choose(Vec2& u) const;

 private:
  std::vector<Corners> corners_;
  std::vector<double> sums_;  ///< of areas up to and with each
  Bounds3 bounds_;
};

/// Null where there are none.
std::unique_ptr<const SurfaceSampler> make_triangle_sampler(
    std::shared_ptr<const TriangleSet> triangles, const Transform& world_from_object,
    bool flip_normals);

}  // namespace tessera
