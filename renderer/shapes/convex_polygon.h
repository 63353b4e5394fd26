#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderer/math/numbers.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/shape.h"

namespace tessera {

#include "renderer/shapes/rectangle-inl.h"

/// A flat convex polygon, counter-clockwise seen from its front. Its edges are tested as those of
/// the watertight triangle test, so polygons and triangles that share vertices leave no crack
/// (where no three points are in a line, which rounding could bend inward). Texture coordinates
/// start at the first point, u along the first edge, and reach 1 at the longer side of the
/// rectangle around it.
class ConvexPolygon final : public Shape {
 public:
  /// Throws Error where there is a fault_of(points).
  explicit ConvexPolygon(std::vector<Point3> points);
  /// Why the points are no polygon; empty for at least three finite ones round a convex area, in
  /// either sense, flat to within a millionth of their extent; three in a line are allowed.
  static std::string fault_of(std::span<const Point3> points);

  std::span<const Point3> points() const { return points_; }
  Bounds3 bounds() const override { return bounds_; }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  /// By area.
  std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                     bool flip_normals) const override;
  std::vector<Point3> outline() const override { return points_; }

 private:
  std::vector<Point3> points_;
  Vec3 normal_;  ///< not of unit length
  Point3 uv_origin_;
  Vec3 dpdu_, dpdv_;
  Bounds3 bounds_;
};

/// The parallelogram corner + u edge_u + v edge_v, u and v in [0, 1]; its front is where
/// edge_u x edge_v points. Watertight as ConvexPolygon.
class Rectangle final : public Shape {
 public:
  /// Throws Error where the edges are parallel or not finite.
  Rectangle(const Point3& corner, const Vec3& edge_u, const Vec3& edge_v);
  const Point3& corner() const { return corner_; }
  const Vec3& edge_u() const { return edge_u_; }
  const Vec3& edge_v() const { return edge_v_; }
  const Vec3& normal() const { return normal_; }    ///< edge_u x edge_v
  const Vec3& share_u() const { return share_u_; }  ///< its product with edge_u is 1, with edge_v 0
  const Vec3& share_v() const { return share_v_; }  ///< the other way round
  int axis() const { return axis_; }                ///< along which the normal is; -1: along none
  Bounds3 bounds() const override;
  /// Also a lane each in instance_soa-inl.h, bit for bit.
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  /// By solid angle (Urena et al. 2013, "An Area-Preserving Parametrization for Spherical
  /// Rectangles") where it is near; else, or where it is no rectangle, about so, by densities that
  /// are linear along both edges.
  std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                     bool flip_normals) const override;
  std::vector<Point3> outline() const override {
    return {corner_, corner_ + edge_u_, corner_ + edge_v_, corner_ + edge_u_ + edge_v_};
  }
  /// closest_hit() for a ray that is known to be inside the edges where it meets the plane.
  bool closest_hit_inside(const Ray& ray, Hit& hit, TraversalCounters& counters) const;
  bool any_hit_inside(const Ray& ray, TraversalCounters& counters) const;
  /// What is hit at `t`, of the instance of `hit`.
  Hit hit_at(const Ray& ray, double t, const Hit& hit) const;

 private:
  bool crosses(const Ray& ray, const Hit& hit, double& t) const;

  Point3 corner_;
  Vec3 edge_u_, edge_v_, normal_, unit_normal_, share_u_, share_v_;
  int axis_ = -1;
};

}  // namespace tessera
