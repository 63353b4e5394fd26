// Written once for single numbers and for lanes (numbers.h): included by triangle_mesh.cpp, and by
// shape_lanes-inl.h for each instruction set.

/// Of what the corners of a triangle have, by their weights.
TESSERA_INLINE Num3 blend(const Num3 (&of_corner)[3], const Num3& weights) {
  return of_corner[0] * weights.x + of_corner[1] * weights.y + of_corner[2] * weights.z;
}
/// Whether the blend of normals, of any length, is one.
TESSERA_INLINE NumMask is_normal(const Num3& n) {
  const NumMask is_finite = (n.x + n.y + n.z) * num(0) == num(0);
  return both(is_finite, dot(n, n) > num(0));
}
/// The point of a triangle by the weights of its corners, and the bound of its error.
TESSERA_INLINE void place_on_triangle(const Num3 (&corner)[3], const Num3& weights, Num3& point,
                                      Num3& error) {
  const Num3 a = corner[0] * weights.x, b = corner[1] * weights.y, c = corner[2] * weights.z;
  point = Num3{num(0), num(0), num(0)} + a + b + c;  // no -0
  error = (abs(a) + abs(b) + abs(c)) * num(gamma(7));
}
