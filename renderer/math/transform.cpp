#include "renderer/math/transform.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/math/rounding.h"

namespace tessera {
namespace {

Affine from_columns(const Vec3& x, const Vec3& y, const Vec3& z, const Point3& origin) {
  Affine a;
  for (int r = 0; r < 3; ++r) a.m[r] = {x[r], y[r], z[r], origin[r]};
  return a;
}

/// A power of two by which the linear part is to be multiplied before it is inverted: 1, unless its
/// determinant is too large or too small for a number while its parts are not.
double balance_of(const Affine& a) {
  const double determinant = std::abs(a.determinant());
  if (determinant > 1e-300 && determinant < 1e300) return 1;
  double largest = 0;
  for (const auto& row : a.m)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(row[c]));
  if (!(largest > 0) || !std::isfinite(largest)) return 1;
  return std::ldexp(1, -std::clamp(std::ilogb(largest), -1022, 1022));
}

Affine scaled(Affine a, double by) {
  for (auto& row : a.m)
    for (int c = 0; c < 3; ++c) row[c] *= by;
  return a;
}

}  // namespace

double Affine::determinant() const {
  return m[0][0] * difference_of_products(m[1][1], m[2][2], m[1][2], m[2][1]) -
         m[0][1] * difference_of_products(m[1][0], m[2][2], m[1][2], m[2][0]) +
         m[0][2] * difference_of_products(m[1][0], m[2][1], m[1][1], m[2][0]);
}

Affine operator*(const Affine& a, const Affine& b) {
  Affine c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) {
      const double sum = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
      c.m[i][j] = j == 3 ? sum + a.m[i][3] : sum;
    }
  }
  return c;
}

Affine inverse(const Affine& given) {
  const double balance = balance_of(given);
  const Affine a = balance == 1 ? given : scaled(given, balance);
  const double determinant = a.determinant();
  Affine b;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      b.m[j][i] =
          difference_of_products(a.m[i1][j1], a.m[i2][j2], a.m[i1][j2], a.m[i2][j1]) / determinant;
    }
  }
  if (balance != 1) b = scaled(b, balance);
  const Vec3 moved = b(Vec3{a.m[0][3], a.m[1][3], a.m[2][3]});
  // 0 - x, so that no shift gives +0 and the inverse of the identity is the identity.
  for (int r = 0; r < 3; ++r) {
    b.m[r][3] = 0 - moved[r];
    for (int c = 0; c < 3; ++c) b.m[r][c] += 0.0;
  }
  return b;
}

double condition(const Affine& a, const Affine& inverse) {
  double largest = 0;
  for (const auto& row : a.m) {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c)
      for (size_t k = 0; k < 3; ++k) sum += std::abs(row[k]) * std::abs(inverse.m[k][c]);
    largest = std::max(largest, sum);
  }
  return largest;
}

bool is_finite(const Affine& a) {
  for (const auto& row : a.m)
    for (const double value : row)
      if (!std::isfinite(value)) return false;
  return true;
}

bool is_invertible(const Affine& a) {
  const double determinant = scaled(a, balance_of(a)).determinant();
  if (!std::isfinite(determinant) || determinant == 0 || !std::isfinite(1 / determinant))
    return false;
  const Affine inverted = inverse(a);
  // Beyond, nothing but rounding is left of where it leads: it was flat before it was multiplied.
  constexpr double kLargestCondition = 0x1p46;
  return is_finite(inverted) && condition(a, inverted) <= kLargestCondition;
}

Affine translation(const Vec3& by) {
  return from_columns({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {by.x, by.y, by.z});
}

Affine scaling(const Vec3& by) {
  return from_columns({by.x, 0, 0}, {0, by.y, 0}, {0, 0, by.z}, {0, 0, 0});
}

Affine rotation(const Vec3& axis, double angle) {
  const Vec3 k = normalize(axis);
  const double s = portable::sin(angle), c = portable::cos(angle);
  const auto turned = [&](const Vec3& v) {
    return v * c + cross(k, v) * s + k * (dot(k, v) * (1 - c));
  };
  return from_columns(turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1}), {0, 0, 0});
}

Affine look_at(const Point3& eye, const Point3& target, const Vec3& up) {
  const Vec3 z = normalize(eye - target);
  Vec3 x = cross(up, z);
  for (const Vec3& other : {Vec3{1, 0, 0}, Vec3{0, 0, 1}}) {
    if (length(x) > 1e-12 * length(up)) break;
    x = cross(other, z) * length(up);
  }
  x = normalize(x);
  return from_columns(x, cross(z, x), z, eye);
}

Bounds3 Transform::bounds(const Bounds3& b) const {
  if (b.empty()) return b;
  Bounds3 mapped;
  for (int corner = 0; corner < 8; ++corner) {
    const Point3 p{corner & 1 ? b.max.x : b.min.x, corner & 2 ? b.max.y : b.min.y,
                   corner & 4 ? b.max.z : b.min.z};
    const Point3 q = point(p);
    const Vec3 error = point_error(p, {});
    mapped.extend(q - error);
    mapped.extend(q + error);
  }
  for (int a = 0; a < 3; ++a) {
    // An endless side times 0 is NaN, which extend() drops: such a side stays endless.
    if (!(std::isfinite(mapped.min[a]) && std::isfinite(mapped.max[a]))) {
      mapped.min[a] = -Bounds3::kInfinity;
      mapped.max[a] = Bounds3::kInfinity;
    }
    mapped.min[a] = next_down(mapped.min[a]);
    mapped.max[a] = next_up(mapped.max[a]);
  }
  return mapped;
}

Vec3 Transform::point_error(const Point3& p, const Vec3& error) const {
  const Vec3 v = to_vec(p);
  return {error_of_product(to_.m[0], v, error), error_of_product(to_.m[1], v, error),
          error_of_product(to_.m[2], v, error)};
}

}  // namespace tessera
