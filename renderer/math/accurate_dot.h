#pragma once

#include <cstddef>

#include "renderer/math/rounding.h"
#include "renderer/math/vec.h"

namespace tessera {

/// a[0] b[0] + ... + a[N-1] b[N-1] as if summed in twice the working precision and rounded once
/// (Ogita, Rump, Oishi 2005, algorithm Dot2), in the range of two_product.
/// Also a lane each in instance_soa-inl.h, to the bit.
template <size_t N>
double accurate_dot(const double (&a)[N], const double (&b)[N]) {
  DoubleDouble sum = two_product(a[0], b[0]);
  for (size_t i = 1; i < N; ++i) {
    const DoubleDouble product = two_product(a[i], b[i]);
    const DoubleDouble next = two_sum(sum.high, product.high);
    sum = {next.high, sum.low + (next.low + product.low)};
  }
  return sum.high + sum.low;
}

inline double accurate_dot(const Vec3& a, const Vec3& b) {
  return accurate_dot({a.x, a.y, a.z}, {b.x, b.y, b.z});
}

/// a x b, right in every component to 2 ulp.
/// Also a lane each in lane_triangle-inl.h, to the bit.
inline Vec3 accurate_cross(const Vec3& a, const Vec3& b) {
  return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
          difference_of_products(a.x, b.y, a.y, b.x)};
}

}  // namespace tessera
