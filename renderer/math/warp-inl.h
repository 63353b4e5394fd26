// Written once for single numbers and for lanes (numbers.h): included by warp.h, and by
// lambert_lanes-inl.h for each instruction set.

/// Sine and cosine of |x| <= pi / 4, to 1e-13, by their series: in pairs of terms, which do not
/// wait for each other.
TESSERA_INLINE Num2 small_sine_cosine(Num x) {
  const Num q = x * x, q2 = q * q, q4 = q2 * q2;
  const Num sine =
      (num(1) - q * num(1.0 / 6)) + q2 * (num(1.0 / 120) - q * num(1.0 / 5040)) +
      q4 * ((num(1.0 / 362880) - q * num(1.0 / 39916800)) + q2 * num(1.0 / 6227020800));
  const Num cosine = (num(1) - q * num(1.0 / 2)) + q2 * (num(1.0 / 24) - q * num(1.0 / 720)) +
                     q4 * ((num(1.0 / 40320) - q * num(1.0 / 3628800)) +
                           q2 * (num(1.0 / 479001600) - q * num(1.0 / 87178291200)));
  return {x * sine, cosine};
}

/// Uniform over the unit disc, neighbours staying neighbours (Shirley and Chiu 1997).
TESSERA_INLINE Num2 disc_point(const Num2& u) {
  const Num zero = num(0), a = num(2) * u.x - num(1), b = num(2) * u.y - num(1);
  const NumMask is_middle = both(a == zero, b == zero);
  // Which one is longer is a matter of chance: chosen without a branch.
  const NumMask is_wide = absolute(a) > absolute(b);
  const Num longer = select(is_wide, a, b), shorter = select(is_wide, b, a);
  const Num2 turn = small_sine_cosine(num(portable::kPi / 4) * (shorter / longer));
  const Num along = longer * turn.y, across = longer * turn.x;
  return {select(is_middle, zero, select(is_wide, along, across)),
          select(is_middle, zero, select(is_wide, across, along))};
}

/// Over the hemisphere about +z by the cosine; its density is z / pi (Malley's method).
TESSERA_INLINE Num3 cosine_hemisphere_point(const Num2& u) {
  const Num2 d = disc_point(u);
  return {d.x, d.y, square_root(maximum(num(0), num(1) - d.x * d.x - d.y * d.y))};
}
