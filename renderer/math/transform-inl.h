// Written once for single numbers and for lanes (numbers.h): included by transform.h, and by
// shape_lanes-inl.h for each instruction set.

using MatrixRow = std::array<double, 4>;

TESSERA_INLINE Num times_point(const MatrixRow& m, const Num3& p) {
  return (num(m[0]) * p.x + num(m[1]) * p.y) + (num(m[2]) * p.z + num(m[3]));
}
/// |m[0]| v.x + |m[1]| v.y + |m[2]| v.z
TESSERA_INLINE Num times_size(const MatrixRow& m, const Num3& v) {
  return num(std::abs(m[0])) * v.x + num(std::abs(m[1])) * v.y + num(std::abs(m[2])) * v.z;
}
/// Bound on what rounding adds to times_point(m, p).
TESSERA_INLINE Num rounding_of_product(const MatrixRow& m, const Num3& p) {
  return num(gamma(4)) * (times_size(m, abs(p)) + num(std::abs(m[3])));
}
/// Bound on the absolute error of times_point(m, p) where p is known to within `error` (PBRT 4ed,
/// 6.8.1).
TESSERA_INLINE Num error_of_product(const MatrixRow& m, const Num3& p, const Num3& error) {
  return num(gamma(3) + 1) * times_size(m, error) + rounding_of_product(m, p);
}
/// Takes a point of a surface into world space by `to`; the bound of its error then counts the way
/// back by `from` too.
TESSERA_INLINE void move_point(const Affine& to, const Affine& from, Num3& point, Num3& error) {
  const Num3 p = point;
  point = {times_point(to.m[0], p), times_point(to.m[1], p), times_point(to.m[2], p)};
  const Num3 back{rounding_of_product(from.m[0], point), rounding_of_product(from.m[1], point),
                  rounding_of_product(from.m[2], point)};
  error = {error_of_product(to.m[0], p, error) + times_size(to.m[0], back),
           error_of_product(to.m[1], p, error) + times_size(to.m[1], back),
           error_of_product(to.m[2], p, error) + times_size(to.m[2], back)};
}
TESSERA_INLINE Num column_times(const Affine& a, size_t column, const Num3& v) {
  return num(a.m[0][column]) * v.x + num(a.m[1][column]) * v.y + num(a.m[2][column]) * v.z;
}
/// By the transpose of the inverse, `from`; not of unit length.
TESSERA_INLINE Num3 moved_normal(const Affine& from, const Num3& n) {
  return {column_times(from, 0, n), column_times(from, 1, n), column_times(from, 2, n)};
}
