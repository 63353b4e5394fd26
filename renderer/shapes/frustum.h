#pragma once

#include "renderer/shapes/solid.h"

namespace tessera {

/// Parts of a round solid that are left out.
struct OpenParts {
  bool side = false, top = false, bottom = false;
};

/// The solid of revolution about the y axis between y = -height / 2 and height / 2 whose radius
/// goes from `bottom_radius` to `top_radius` in a straight line: a cylinder, a cone or a frustum.
/// Primitives are its parts: side, top, bottom. Textures as X3D maps them: round the side from the
/// seam at -z, counter-clockwise seen from above, and v from the bottom; a cap's disc is cut from
/// the unit square, up being -z on the top and +z on the bottom.
///
/// The roots come from coefficients in twice the working precision, the discriminant from the
/// line's moments, and whether an origin is inside is told by an exact sign; so hits are right from
/// any distance and a ray that starts off the surface neither meets it again nor misses the far
/// wall.
class Frustum : public ConvexSolid {
 public:
  enum Part : uint32_t { kSide, kTop, kBottom };

  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  size_t primitive_count() const override { return 3; }
  bool closed() const override { return !(open_.side || open_.top || open_.bottom); }
  bool span(const Ray& ray, const RayError& error, SolidSpan& span) const override;
  /// By area.
  std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                     bool flip_normals) const override;
  std::vector<Point3> outline() const override;

 protected:
  /// Throws Error unless the height is > 0 and the radii >= 0, finite and not both 0.
  Frustum(double bottom_radius, double top_radius, double height, const OpenParts& open);

 private:
  struct Crossing {
    double t;
    Part part;
  };
  struct Stretch {
    double enter, leave;
  };

  bool is_open(Part part) const;
  double radius_at(double y) const { return mean_radius_ + slope_ * y; }
  /// Where the line is inside the endless cone (one nappe) or cylinder; false for nowhere.
  bool cross_side(const Point3& o, const Vec3& d, Stretch& inside) const;
  bool cross(const Ray& ray, Crossing& enter, Crossing& leave) const;
  double event_error(const Ray& ray, const Crossing& at, const RayError& error) const;
  void side_surface(const Point3& near_side, LocalSurface& s) const;
  void cap_surface(const Point3& near_cap, bool top, LocalSurface& s) const;

  double bottom_radius_, top_radius_, half_height_;
  double mean_radius_, slope_;          ///< the radius is mean + slope y
  double mean_radius_low_, slope_low_;  ///< what the two above miss by rounding
  OpenParts open_;
};

/// A cylinder along the y axis, centred at the origin.
class Cylinder final : public Frustum {
 public:
  Cylinder(double radius, double height, const OpenParts& open = {})
      : Frustum(radius, radius, height, open) {}
};

/// A cone about the y axis with its base at y = -height / 2 and its apex, or the lid that cuts it
/// off, at height / 2.
class Cone final : public Frustum {
 public:
  Cone(double radius, double height, double top_radius = 0, const OpenParts& open = {})
      : Frustum(radius, top_radius, height, open) {}
};

}  // namespace tessera
