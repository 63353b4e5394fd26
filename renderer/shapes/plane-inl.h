// Written once for single numbers and for lanes (numbers.h): included by plane.h, and by
// shape_lanes-inl.h for each instruction set.

/// The points p with normal . p = offset.
struct PlaneEquation {
  Num3 normal;  ///< of unit length
  Num offset;

  TESSERA_INLINE Num signed_distance(const Num3& p) const { return dot(normal, p) - offset; }
  /// Bound on the absolute error of signed_distance(p).
  TESSERA_INLINE Num distance_error(const Num3& p) const {
    return num(gamma(4)) *
           (l1_norm({normal.x * p.x, normal.y * p.y, normal.z * p.z}) + absolute(offset));
  }
  /// Takes a point that an intersection found onto the plane; `error` is then how far off it may
  /// be.
  TESSERA_INLINE void place(Num3& point, Num3& error) const {
    point = point - normal * signed_distance(point);
    error = abs(point) * num(gamma(3)) + abs(normal) * (num(2) * distance_error(point));
  }
};
