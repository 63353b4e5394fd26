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
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  void crossings(const Ray& ray, const RayError& error,
                 std::vector<SolidEvent>& events) const override;

 private:
  /// Crossings of the line in ascending order, alternately entering and leaving.
  struct Roots {
    int count = 0;
    std::array<double, 6> t;
  };
  /// A point's distance from the surface, < 0 inside.
  double signed_distance(double x, double y, double z) const;
  Roots find_roots(const Ray& ray) const;

  double major_, minor_;
};

}  // namespace tessera
