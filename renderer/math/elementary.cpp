#include "renderer/math/elementary.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "renderer/math/arc_table.h"
#include "renderer/math/rounding.h"

// Every function reduces its argument to a short interval, carries the leading terms as a sum of
// two doubles, adds a Taylor tail in plain double and rounds once. Scaling by powers of two uses
// bits and std::ldexp, both exact.

namespace tessera::portable {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
// pi/2 as 33 + 33 + 53 bits so that small multiples are exact.
constexpr double kPi2A = 0x1.921fb544p+0, kPi2B = 0x1.0b4611a6p-34, kPi2C = 0x1.3198a2e037073p-69;
constexpr DoubleDouble kLn2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
constexpr double kLn2A = 0x1.62e42feep-1, kLn2B = 0x1.a39ef35793c76p-33;

DoubleDouble normalized(double high, double low) { return fast_two_sum(high, low); }
DoubleDouble add(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble s = two_sum(a.high, b.high);
  return normalized(s.high, s.low + (a.low + b.low));
}
DoubleDouble multiply(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble p = two_product(a.high, b.high);
  return normalized(p.high, p.low + (a.high * b.low + a.low * b.high));
}
DoubleDouble divide(DoubleDouble a, DoubleDouble b) {
  const double q = a.high / b.high;
  const DoubleDouble back = two_product(q, b.high);
  const double rest = ((a.high - back.high) - back.low) + (a.low - q * b.low);
  return normalized(q, rest / b.high);
}
DoubleDouble negated(DoubleDouble a) { return {-a.high, -a.low}; }
double rounded(DoubleDouble a) { return a.high + a.low; }

/// x - quarter * pi/2 in [-pi/4, pi/4].
DoubleDouble reduce(double x, int& quarter) {
  const double k = std::nearbyint(x * 0x1.45f306dc9c883p-1);
  quarter = static_cast<int>(static_cast<int64_t>(k) & 3);
  const DoubleDouble a = two_sum(x - k * kPi2A, -(k * kPi2B));
  const DoubleDouble c = two_product(k, kPi2C);
  const DoubleDouble s = two_sum(a.high, -c.high);
  return normalized(s.high, s.low + (a.low - c.low));
}

DoubleDouble sine_kernel(DoubleDouble r) {
  const double z = r.high * r.high;
  double p = 1.0 / 355687428096000;
  for (const double factorial : {-1307674368000., 6227020800., -39916800., 362880., -5040., 120.})
    p = 1 / factorial + z * p;
  // The cubic term needs more than 53 bits near pi/4.
  const DoubleDouble square = two_product(r.high, r.high);
  const DoubleDouble sixth = multiply(square, {-0x1.5555555555555p-3, -0x1.5555555555555p-57});
  const DoubleDouble cubic = multiply(sixth, {r.high, 0});
  const double tail = z * z * r.high * p + r.low * (1 - 0.5 * z);
  const DoubleDouble s = fast_two_sum(r.high, cubic.high);
  return normalized(s.high, s.low + (cubic.low + tail));
}

DoubleDouble cosine_kernel(DoubleDouble r) {
  const double z = r.high * r.high;
  double p = -1.0 / 6402373705728000;
  for (const double factorial :
       {20922789888000., -87178291200., 479001600., -3628800., 40320., -720., 24.})
    p = 1 / factorial + z * p;
  const DoubleDouble square = two_product(r.high, r.high);
  const DoubleDouble s = fast_two_sum(1, -0.5 * square.high);
  return normalized(s.high, s.low + (z * z * p - (0.5 * square.low + r.high * r.low)));
}

DoubleDouble sine_of_quarter(DoubleDouble r, int quarter) {
  const DoubleDouble s = quarter & 1 ? cosine_kernel(r) : sine_kernel(r);
  return quarter & 2 ? negated(s) : s;
}

/// The arc tangent of q in [0, 1]: from the nearest multiple c of 1/8 the rest is small.
DoubleDouble arc_kernel(DoubleDouble q) {
  const int n = static_cast<int>(std::nearbyint(q.high * 8));
  const double c = n * 0.125;
  DoubleDouble t = q;
  if (n > 0) {
    const DoubleDouble qc{q.high * c, q.low * c};  // inexact only below 2^-53 of 1
    const DoubleDouble exact = two_product(q.high, c);
    const DoubleDouble below = add({1, 0}, {exact.high, exact.low + qc.low});
    t = divide(normalized(q.high - c, q.low), below);
  }
  const double z = t.high * t.high;
  double p = 0;
  for (const double odd : {17., -15., 13., -11., 9., -7., 5., -3.}) p = z * (1 / odd + p);
  const DoubleDouble s = two_sum(kArc[n].high, t.high);
  return normalized(s.high, s.low + (kArc[n].low + t.low + t.high * p));
}

/// The angle of the point (x, y), y >= 0, not both zero, both finite.
double angle_of(DoubleDouble y, DoubleDouble x) {
  const bool left = x.high < 0;
  if (left) x = negated(x);
  const bool steep = y.high > x.high;
  if (steep) std::swap(x, y);
  // Bring the larger one near 1, so that nothing in the exact division leaves the range.
  if (x.high >= 0x1p-500 && x.high < 0x1p500) [[likely]] {
    const auto exponent = std::bit_cast<uint64_t>(x.high) >> 52;
    const double scale = std::bit_cast<double>((2046 - exponent) << 52);  // 2^-ilogb(x)
    x = {x.high * scale, x.low * scale};
    y = {y.high * scale, y.low * scale};
  } else {
    const int scale = -std::ilogb(x.high);
    x = {std::ldexp(x.high, scale), std::ldexp(x.low, scale)};
    y = {std::ldexp(y.high, scale), std::ldexp(y.low, scale)};
  }
  DoubleDouble a{y.high / x.high, 0};
  if (a.high > 1e-280) a = divide(y, x);
  a = arc_kernel(a);
  if (steep) a = add(kPi2, negated(a));
  if (left) a = add(kPiDd, negated(a));
  return rounded(a);
}

double leading_bits(double x) {
  return std::bit_cast<double>(std::bit_cast<uint64_t>(x) & ~QuickArc::kLastBits);
}

/// angle_of() for plain numbers, in a third of the time; false where it cannot be sure of the bits
/// (Ziv, Fast Evaluation of Elementary Mathematical Functions with Correctly Rounded Last Bit,
/// 1991): it sums in another order, and the two are off by much less than `doubt`.
bool quick_angle_of(double y, double x, double& angle) {
  using Arc = QuickArc;
  const bool left = x < 0;
  const bool steep = y > std::abs(x);
  const double large = steep ? y : std::abs(x), small = steep ? std::abs(x) : y;
  if (!(large < Arc::kMost && large > Arc::kLeast && small > large * Arc::kLeastRatio))
    return false;
  // From the nearest multiple c of 1/8 on.
  const int n = static_cast<int>(small / large * 8 + Arc::kNearlyHalf);
  const double c = n * 0.125;
  const double large_high = leading_bits(large), small_high = leading_bits(small);
  const double across = (small - c * large_high) - c * (large - large_high);
  const double more = c * small;
  const DoubleDouble along = fast_two_sum(large, more);
  const double along_low = along.low + ((c * small_high - more) + c * (small - small_high));
  const double t = across / along.high, inverse = 1 / along.high;
  const DoubleDouble back = two_product(t, along.high);
  const double t_low = (((across - back.high) - back.low) - t * along_low) * inverse;
  const double z = t * t, zz = z * z;
  const double p =
      z * ((z * Arc::k5 + Arc::k3) +
           zz * ((z * Arc::k9 + Arc::k7) + zz * (z * Arc::k13 + Arc::k11 - zz / Arc::kBy15)));
  // Where that angle begins, and the way it goes round.
  const double sign = left == steep ? 1 : -1;
  const DoubleDouble axis = steep ? kPi2 : left ? kPiDd : DoubleDouble{};
  const DoubleDouble begin = two_sum(axis.high, sign * kArc[n].high);
  const DoubleDouble sum = fast_two_sum(begin.high, sign * t);
  const double tail = t * p;
  const double low =
      (sum.low + (begin.low + (axis.low + sign * (kArc[n].low + t_low)))) + sign * tail;
  const double doubt = std::abs(tail) * Arc::kTailDoubt + sum.high * Arc::kSumDoubt;
  angle = sum.high + low;
  return sum.high + (low - doubt) == sum.high + (low + doubt);
}

/// sqrt(1 - x^2) for |x| <= 1.
DoubleDouble cosine_of_arcsine(double x) {
  const DoubleDouble square = two_product(x, x);
  const DoubleDouble s = two_sum(1, -square.high);
  const DoubleDouble d = normalized(s.high, s.low - square.low);
  if (!(d.high > 0)) return {0, 0};
  const double root = std::sqrt(d.high);
  const DoubleDouble back = two_product(root, root);
  return normalized(root, (((d.high - back.high) - back.low) + d.low) / (2 * root));
}

double exponential(DoubleDouble x) {
  if (x.high > 710) return kInf;
  if (x.high < -746) return 0;
  const double k = std::nearbyint(x.high * 0x1.71547652b82fep+0);
  const double a = x.high - k * kLn2A;  // exact: 31 bits times 11 bits
  const DoubleDouble b = two_product(k, kLn2B);
  const DoubleDouble r = two_sum(a, -b.high);
  const double low = r.low - b.low + x.low;
  const double h = r.high;
  double p = 1.0 / 6227020800;
  for (const double factorial :
       {479001600., 39916800., 3628800., 362880., 40320., 5040., 720., 120., 24., 6.})
    p = 1 / factorial + h * p;
  const DoubleDouble square = two_product(h, h);
  const DoubleDouble s = fast_two_sum(1, h);
  const DoubleDouble u = fast_two_sum(s.high, 0.5 * square.high);
  const double cubic = h * square.high * p;
  const double tail = cubic + 0.5 * square.low + low * (u.high + cubic);
  return std::ldexp(u.high + (u.low + (s.low + tail)), static_cast<int>(k));
}

/// log(x) for finite x > 0, to about 2^-66 relative where x is not near 1, and never worse than
/// that relative to log(x) itself.
DoubleDouble logarithm(double x) {
  int k = std::ilogb(x);
  double m = std::ldexp(x, -k);
  if (m > 0x1.6a09e667f3bcdp+0) {
    m *= 0.5;
    ++k;
  }
  const double f = m - 1;
  const DoubleDouble s = divide({f, 0}, two_sum(2, f));
  const DoubleDouble z = multiply(s, s);
  const double w = z.high;
  double p = 0;
  for (const double odd : {25., 23., 21., 19., 17., 15., 13., 11., 9.}) p = w * (1 / odd + p);
  // 1/7 and before in double-double: pow magnifies the error of the logarithm up to 745 times.
  DoubleDouble q = two_sum(0x1.2492492492492p-3, p);
  q.low += 0x1.2492492492492p-57;
  q = add({0x1.999999999999ap-3, -0x1.999999999999ap-57}, multiply(z, q));
  q = add({0x1.5555555555555p-2, 0x1.5555555555555p-56}, multiply(z, q));
  const DoubleDouble twice{2 * s.high, 2 * s.low};
  const DoubleDouble of_m = add(twice, multiply(twice, multiply(z, q)));
  if (k == 0) return of_m;
  const DoubleDouble of_k = multiply({static_cast<double>(k), 0}, kLn2);
  return add(of_k, of_m);
}

}  // namespace

double sin(double x) {
  if (!std::isfinite(x)) return kNan;
  if (std::abs(x) < 1e-9) return x;
  int quarter;
  const DoubleDouble r = reduce(x, quarter);
  return rounded(sine_of_quarter(r, quarter));
}

double cos(double x) {
  if (!std::isfinite(x)) return kNan;
  int quarter;
  const DoubleDouble r = reduce(x, quarter);
  return rounded(sine_of_quarter(r, quarter + 1));
}

double tan(double x) {
  if (!std::isfinite(x)) return kNan;
  if (std::abs(x) < 1e-9) return x;
  int quarter;
  const DoubleDouble r = reduce(x, quarter);
  return rounded(divide(sine_of_quarter(r, quarter), sine_of_quarter(r, quarter + 1)));
}

double asin(double x) {
  if (!(std::abs(x) <= 1)) return kNan;
  if (std::abs(x) < 1e-9) return x;
  return std::copysign(angle_of({std::abs(x), 0}, cosine_of_arcsine(x)), x);
}

double acos(double x) {
  if (!(std::abs(x) <= 1)) return kNan;
  return angle_of(cosine_of_arcsine(x), {x, 0});
}

double atan(double x) {
  if (std::isnan(x)) return kNan;
  if (std::abs(x) < 1e-9) return x;
  return atan2(x, 1);
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNan;
  if (std::isinf(y)) {
    const double steep = std::isinf(x) ? kPi / 4 : kPi / 2;
    return std::copysign(std::isinf(x) && x < 0 ? 3 * (kPi / 4) : steep, y);
  }
  if (std::isinf(x) || y == 0) {
    return std::copysign(std::signbit(x) ? kPi : 0.0, y);
  }
  double angle;
  if (!quick_angle_of(std::abs(y), x, angle)) angle = angle_of({std::abs(y), 0}, {x, 0});
  return std::copysign(angle, y);
}

double exp(double x) { return std::isnan(x) ? kNan : exponential({x, 0}); }

double log(double x) {
  if (!(x >= 0)) return kNan;
  if (x == 0) return -kInf;
  return std::isinf(x) ? x : rounded(logarithm(x));
}

double pow(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (!(x >= 0) || std::isnan(y)) return kNan;
  if (x == 0) return y > 0 ? 0 : kInf;
  if (std::isinf(y)) return (x > 1) == (y > 0) ? kInf : 0;
  if (std::isinf(x)) return y > 0 ? kInf : 0;
  const DoubleDouble l = logarithm(x);
  const double p = y * l.high;
  if (!(std::abs(p) < 800)) return p > 0 ? kInf : 0;
  if (std::abs(p) < 1e-17) return 1;
  const DoubleDouble exact = std::abs(y) < 1e280 ? two_product(y, l.high) : DoubleDouble{p, 0};
  return exponential(normalized(exact.high, exact.low + y * l.low));
}

}  // namespace tessera::portable
