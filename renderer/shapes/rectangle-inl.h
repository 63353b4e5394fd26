// Written once for single numbers and for lanes (numbers.h): included by convex_polygon.h, and by
// shape_lanes-inl.h for each instruction set.

/// The point at corner + along + up, and the bound of its error; the last two are products with
/// edges.
TESSERA_INLINE void place_on_rectangle(const Num3& corner, const Num3& along, const Num3& up,
                                       Num3& point, Num3& error) {
  point = corner + along + up;
  error = (abs(along) + abs(up)) * num(gamma(8)) + (abs(corner) + abs(point)) * num(gamma(3));
}
