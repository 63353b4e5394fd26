// Written once for single numbers and for lanes (numbers.h): included by triangle_mesh.cpp, and by
// shape_lanes-inl.h for each instruction set.

/// The point of a triangle by the weights of its corners, and the bound of its error.
TESSERA_INLINE void place_on_triangle(const Num3 (&corner)[3], const Num3& weights, Num3& point,
                                      Num3& error) {
  const Num3 a = corner[0] * weights.x, b = corner[1] * weights.y, c = corner[2] * weights.z;
  point = Num3{num(0), num(0), num(0)} + a + b + c;  // no -0
  error = (abs(a) + abs(b) + abs(c)) * num(gamma(7));
}
