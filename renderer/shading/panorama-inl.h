// Written once for single numbers and for lanes (numbers.h): included by background.h, and by
// light_lanes-inl.h for each instruction set.

/// Where in the picture of a panorama, which `angle` radians turn, lies what is seen along `d`, a
/// unit direction of the background.
TESSERA_INLINE Num2 place_in_panorama(BackgroundKind kind, double angle, const Num3& d) {
  const Num azimuth = arc_tangent(d.x, negated(d.z)) + num(angle);
  const Num s = num(0.5) + azimuth / num(2 * portable::kPi);
  const Num t = kind == BackgroundKind::panorama_equal_area
                    ? num(0.5) - d.y / num(2)
                    : arc_tangent(square_root(d.x * d.x + d.z * d.z), d.y) / num(portable::kPi);
  return {s - floor_of(s), t};
}
