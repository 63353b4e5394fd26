// Written once for single numbers and for lanes (numbers.h): included by light_sampling.h, and by
// path_wavefront_lights-inl.h for each instruction set.

/// The weight of a sample of density `own` among those of two ways to sample (Veach 1997, 9.2.4).
TESSERA_INLINE Num power_heuristic(Num own, Num other) {
  const Num ratio = other / own;
  return num(1) / (num(1) + ratio * ratio);
}
/// Where a stretch to a point of a surface ends: before it, as stretches begin after the surface
/// that they leave. `back` leads from that point to where the stretch begins.
TESSERA_INLINE Num3 end_before(const Num3& point, const Num3& error, const Num3& normal,
                               const Num3& back) {
  const Num3 side = select(dot(back, normal) < num(0), -normal, normal);
  const Num lift = dot(abs(side), error) + num(kLiftRoundings) * l1_norm(back);
  return point + side * lift;
}
