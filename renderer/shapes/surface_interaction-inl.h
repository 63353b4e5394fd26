// Written once for single numbers and for lanes (numbers.h): included by surface_interaction.h, and
// by shape_lanes-inl.h for each instruction set.

/// What move_point() makes of them under the identity, bit for bit.
TESSERA_INLINE void keep_point(Num3& point, Num3& error) {
  point = point + Num3{num(0), num(0), num(0)};  // no -0
  const Num3 size = abs(point) * num(gamma(4));
  error = error * num(gamma(3) + 1) + size + size;
}
/// What moved_normal() makes of a normal under the identity, once it is normalized.
TESSERA_INLINE Num3 kept_normal(const Num3& normal) {
  const Num3 n = normal + Num3{num(0), num(0), num(0)};
  const NumMask is_unit = dot(n, n) == num(1);
  return is_all(is_unit) ? n : select(is_unit, n, normalize(n));
}
/// `flip`: the back becomes the front. The shading normal comes to the front's side, as
/// kFlipCosine says.
TESSERA_INLINE void turn_normals(bool flip, Num3& front, Num3& shading) {
  if (flip) front = -front, shading = -shading;
  shading = select(dot(front, shading) < num(kFlipCosine), -shading, shading);
}
/// Where rays to that side of a surface start: moved off along its normal by the error bound, and
/// rounded outward (PBRT 4ed, 6.8.6).
TESSERA_INLINE Num3 moved_off(const Num3& point, const Num3& error, const Num3& normal,
                              NumMask is_behind) {
  const Num reach = dot(abs(normal), error);
  const Num3 offset = normal * select(is_behind, negated(reach), reach);
  const Num3 origin = point + offset;
  return {next_towards(origin.x, offset.x), next_towards(origin.y, offset.y),
          next_towards(origin.z, offset.z)};
}
