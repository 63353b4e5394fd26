#pragma once

#include <array>

#include "renderer/shapes/solid.h"

namespace tessera {

/// All points within `minor_radius` of a circle of `major_radius` about the y axis in y = 0. A
/// minor radius above the major one gives a spindle torus: its solid has no cavity and its surface
/// no inner sheet. u turns as a sphere's, v turns round the tube from the inside at 0, upwards on
/// the outside.
///
/// The ray's origin is moved to the point nearest to the centre, found from the line's moment; the
/// quartic's turning points cut the line into pieces with one root each; the sign at a piece's ends
/// and the root inside come from the distance to the circle, not from the quartic, so that thin
/// tori and tangents come out right.
class Torus final : public Solid {
 public:
  /// Radii > 0. Throws Error otherwise.
  Torus(double major_radius, double minor_radius);
  Bounds3 bounds() const override;
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  void crossings(const Ray& ray, const RayError& error,
                 std::vector<SolidEvent>& events) const override;
  /// By area; null for a spindle, where some of it lies inside.
  std::unique_ptr<const SurfaceSampler> make_sampler(const Transform& world_from_object,
                                                     bool flip_normals) const override;
  std::vector<Point3> outline() const override;

 private:
  /// Crossings of the line in ascending order, alternately entering and leaving.
  struct Roots {
    int count = 0;
    std::array<double, 6> t;
  };
  /// The line as p + x d with d of unit length and p nearest to the centre.
  struct CentredLine {
    Point3 p;
    Vec3 d;
    double speed = 0;      ///< length of the ray's direction
    double at_origin = 0;  ///< x at the ray's origin
  };
  struct Stretch {
    double low, high;
  };
  /// A place on the line and its distance from the surface, < 0 inside.
  struct End {
    double x, distance;
  };
  struct Slope {
    double distance, change;  ///< from the surface, and its derivative along the line
    double rise, bend;        ///< first and second derivative of the distance from the axis
  };
  /// False where the line misses the ball of `radius` or has no direction.
  static bool centre_line(const Ray& ray, double radius, CentredLine& line);
  Stretch near_stretch(const CentredLine& line) const;
  Slope slope_at(const CentredLine& line, double x) const;
  void sharpen_turn(const CentredLine& line, bool is_minimum, const Stretch& between,
                    End& turn) const;
  /// Ends of pieces of the line that each cross the surface at most once; their number.
  int find_ends(const CentredLine& line, const Stretch& near, std::array<End, 6>& ends) const;
  Roots find_roots(const Ray& ray) const;

  double major_, minor_;
};

}  // namespace tessera
