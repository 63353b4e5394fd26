// Written once for single numbers and for lanes (numbers.h): included by rounding.h, and by
// lanes-inl.h for each instruction set.

/// a + b exactly (Knuth).
TESSERA_INLINE NumPair two_sum(Num a, Num b) {
  const Num s = a + b, from_b = s - a;
  return {s, (a - (s - from_b)) + (b - from_b)};
}
/// a + b exactly where |a| >= |b| or a is 0 (Dekker).
TESSERA_INLINE NumPair fast_two_sum(Num a, Num b) {
  const Num s = a + b;
  return {s, b - (s - a)};
}
/// a * b exactly (Veltkamp, Dekker), for |a|, |b| < 2^970 and a product above 2^-960.
TESSERA_INLINE NumPair two_product(Num a, Num b) {
  const Num split = num(kSplit);
  const Num p = a * b, ta = a * split, tb = b * split;
  const Num ah = ta - (ta - a), bh = tb - (tb - b);
  const Num al = a - ah, bl = b - bh;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}
/// a * b - c * d with the right sign always and at most 2 ulp off, in the range of two_product.
TESSERA_INLINE Num difference_of_products(Num a, Num b, Num c, Num d) {
  const NumPair ab = two_product(a, b), cd = two_product(c, d);
  const NumPair s = two_sum(ab.high, negated(cd.high)), e = two_sum(ab.low, negated(cd.low));
  const NumPair t = two_sum(s.low, e.high);
  return s.high + (t.high + (t.low + e.low));
}
/// a[0] b[0] + ... + a[N-1] b[N-1] as if summed in twice the working precision and rounded once
/// (Ogita, Rump, Oishi 2005, algorithm Dot2), in the range of two_product.
template <size_t N>
TESSERA_INLINE Num accurate_dot(const Num (&a)[N], const Num (&b)[N]) {
  NumPair sum = two_product(a[0], b[0]);
  for (size_t i = 1; i < N; ++i) {
    const NumPair product = two_product(a[i], b[i]);
    const NumPair next = two_sum(sum.high, product.high);
    sum = {next.high, sum.low + (next.low + product.low)};
  }
  return sum.high + sum.low;
}
TESSERA_INLINE Num accurate_dot(const Num3& a, const Num3& b) {
  return accurate_dot({a.x, a.y, a.z}, {b.x, b.y, b.z});
}
/// a x b, right in every component to 2 ulp.
TESSERA_INLINE Num3 accurate_cross(const Num3& a, const Num3& b) {
  return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
          difference_of_products(a.x, b.y, a.y, b.x)};
}
