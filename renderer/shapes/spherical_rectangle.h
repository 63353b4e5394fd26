#pragma once

#include <algorithm>
#include <array>

#include "renderer/math/elementary.h"
#include "renderer/math/vec.h"

namespace tessera {

/// A rectangle as seen from a point, and points of it spread evenly over the solid angle (Urena,
/// Fajardo and King 2013).
class SphericalRectangle {
 public:
  /// `a` and `b` are the rectangle's edges from `corner`, square to each other.
  SphericalRectangle(const Point3& corner, const Vec3& a, const Vec3& b, const Point3& from)
      : from_(from) {
    const double length_a = length(a), length_b = length(b);
    x_ = a / length_a;
    y_ = b / length_b;
    z_ = cross(x_, y_);
    const Vec3 d = corner - from;
    z0_ = dot(d, z_);
    if (z0_ > 0) {
      z_ = -z_;
      z0_ = -z0_;
    }
    x0_ = dot(d, x_);
    y0_ = dot(d, y_);
    x1_ = x0_ + length_a;
    y1_ = y0_ + length_b;
    if (z0_ == 0) return;  // seen edge on: nothing of it
    // The z of the planes through the eye and each edge.
    const auto plane = [&](double at) { return at / std::sqrt(z0_ * z0_ + at * at); };
    const double n0 = -plane(y0_), n1 = plane(x1_), n2 = plane(y1_), n3 = -plane(x0_);
    const auto angle = [](double p, double q) {
      return portable::acos(std::clamp(-p * q, -1.0, 1.0));
    };
    const double g0 = angle(n0, n1), g1 = angle(n1, n2), g2 = angle(n2, n3), g3 = angle(n3, n0);
    b0_ = n0;
    b1_ = n2;
    k_ = 2 * portable::kPi - g2 - g3;
    solid_angle_ = g0 + g1 - k_;
  }
  double solid_angle() const { return solid_angle_; }
  Point3 point(const Vec2& u) const {
    const double au = u.x * solid_angle_ + k_;
    const double fu = (portable::cos(au) * b0_ - b1_) / portable::sin(au);
    const double sign = fu > 0 ? 1 : -1;
    const double cu = std::clamp(sign / std::sqrt(fu * fu + b0_ * b0_), -1.0, 1.0);
    const double root = std::sqrt(std::max(1 - cu * cu, 1e-300));
    const double xu = std::clamp(-(cu * z0_) / root, x0_, x1_);
    const double d = std::sqrt(xu * xu + z0_ * z0_);
    const double h0 = y0_ / std::sqrt(d * d + y0_ * y0_), h1 = y1_ / std::sqrt(d * d + y1_ * y1_);
    const double hv = h0 + u.y * (h1 - h0), hv2 = hv * hv;
    const double yv = hv2 < 1 - 1e-12 ? std::clamp(hv * d / std::sqrt(1 - hv2), y0_, y1_) : y1_;
    return from_ + x_ * xu + y_ * yv + z_ * z0_;
  }

 private:
  Point3 from_;
  Vec3 x_, y_, z_;
  double x0_ = 0, x1_ = 0, y0_ = 0, y1_ = 0, z0_ = 0;
  double b0_ = 0, b1_ = 0, k_ = 0, solid_angle_ = 0;
};

}  // namespace tessera
