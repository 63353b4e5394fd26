#pragma once

#include <array>

#include "renderer/math/bounds.h"
#include "renderer/math/numbers.h"
#include "renderer/math/rounding.h"
#include "renderer/math/vec.h"

namespace tessera {

/// A 3x4 matrix acting on columns: the fourth row is (0, 0, 0, 1).
struct Affine {
  std::array<std::array<double, 4>, 3> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

  Point3 operator()(const Point3& p) const {
    Point3 q;
    for (int r = 0; r < 3; ++r) q[r] = (m[r][0] * p.x + m[r][1] * p.y) + (m[r][2] * p.z + m[r][3]);
    return q;
  }
  Vec3 operator()(const Vec3& v) const {
    Vec3 w;
    for (int r = 0; r < 3; ++r) w[r] = (m[r][0] * v.x + m[r][1] * v.y) + m[r][2] * v.z;
    return w;
  }
  double determinant() const;  ///< of the 3x3 part
  friend bool operator==(const Affine&, const Affine&) = default;
};

#include "renderer/math/transform-inl.h"

/// a(b(p)).
Affine operator*(const Affine& a, const Affine& b);
/// By cofactors; the caller makes sure that the determinant is neither zero nor not finite.
Affine inverse(const Affine& a);
/// How much rounding grows on the way by `a` and back by its inverse: the largest row sum of
/// |a| |inverse| (Skeel 1979). At most 3 for turns, and for scaling along the axes 1 however
/// uneven.
double condition(const Affine& a, const Affine& inverse);
bool is_finite(const Affine& a);
/// Whether the 3x3 part can be inverted without leaving the range of double or what it resolves.
bool is_invertible(const Affine& a);

Affine translation(const Vec3& by);
Affine scaling(const Vec3& by);
/// Right-handed turn by `angle` radians about `axis` (any length but 0), by Rodrigues' formula with
/// portable sine and cosine.
Affine rotation(const Vec3& axis, double angle);
/// The frame at `eye` whose -z axis points at `target` and whose +y is as near to `up` as can be.
/// Where the view is along `up`, +x takes its place, then +z.
Affine look_at(const Point3& eye, const Point3& target, const Vec3& up);

/// An invertible affine map with its inverse at hand.
class Transform {
 public:
  Transform() = default;
  explicit Transform(const Affine& to)
      : to_(to), from_(inverse(to)), is_identity_(to == Affine{}) {}

  const Affine& matrix() const { return to_; }
  const Affine& inverse_matrix() const { return from_; }
  /// Whether nothing moves at all, so that rays need not be taken into the frame.
  bool is_identity() const { return is_identity_; }

  Point3 point(const Point3& p) const { return to_(p); }
  Vec3 vector(const Vec3& v) const { return to_(v); }
  /// By the inverse transpose; not of unit length.
  Normal3 normal(const Normal3& n) const {
    return to_normal(moved_normal(from_, static_cast<Vec3>(n)));
  }
  Point3 inverse_point(const Point3& p) const { return from_(p); }
  Vec3 inverse_vector(const Vec3& v) const { return from_(v); }
  /// The box of the eight mapped corners, grown outward by the rounding error.
  Bounds3 bounds(const Bounds3& b) const;
  /// Bound on the absolute error of point(p) where p is known to within `error` (PBRT 4ed, 6.8.1).
  Vec3 point_error(const Point3& p, const Vec3& error) const;

 private:
  Affine to_, from_;
  bool is_identity_ = true;
};

}  // namespace tessera
