// Written once for single numbers and for lanes (numbers.h): included by frame.h, and by
// lambert_lanes-inl.h for each instruction set.

/// Three unit vectors square to each other, `z` given (Duff et al. 2017, "Building an Orthonormal
/// Basis, Revisited", JCGT 6(1)).
struct Frame {
  Num3 x, y, z;

  TESSERA_INLINE explicit Frame(const Num3& unit_z) : z(unit_z) {
    const Num one = num(1), sign = copy_sign(one, z.z);
    const Num a = num(-1) / (sign + z.z);
    const Num b = z.x * z.y * a;
    x = {one + sign * z.x * z.x * a, sign * b, negated(sign) * z.x};
    y = {b, sign + z.y * z.y * a, negated(z.y)};
  }
  TESSERA_INLINE Num3 to_local(const Num3& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  TESSERA_INLINE Num3 from_local(const Num3& v) const { return x * v.x + y * v.y + z * v.z; }
};
