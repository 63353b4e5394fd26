#pragma once

#include "renderer/math/color.h"
#include "renderer/math/vec.h"

namespace tessera {

/// Daylight (Preetham, Shirley and Smits 1999, "A Practical Analytic Model for Daylight"): a clear
/// sky whose radiance is 1 where its luminance is 32,000 cd/m^2, about that of white
/// paper in the sun, and the sun as a disc of its true
/// size. Immutable; thread-safe.
class Sky {
 public:
  /// `to_sun` is a unit vector with +y up; turbidity from 2, clear, to 10, hazy. With the sun below
  /// the horizon there is none, and the sky is that of sunset.
  Sky(const Vec3& to_sun, double turbidity, double intensity, const Color& ground_albedo);

  /// Without the sun; below the horizon what an even ground reflects. `d` of unit length.
  Color radiance(const Vec3& d) const;
  bool has_sun() const { return !is_black(sun_); }
  const Color& sun_at_center() const { return sun_; }
  /// Of the sun's disc, zero outside it.
  Color sun_radiance(const Vec3& d) const { return dot(d, to_sun_) >= kCosRadius ? sun_ : kBlack; }
  /// A direction within the disc, and the density of each.
  Vec3 sample_sun(const Vec2& u) const;
  static double sun_density();
  bool is_sun(const Vec3& d) const { return has_sun() && dot(d, to_sun_) >= kCosRadius; }

 private:
  static constexpr double kCosRadius = 0.99998918;  ///< of 0.2665 degrees

  Vec3 to_sun_;
  double perez_[3][5];  ///< of luminance, x and y
  double zenith_[3];    ///< divided by what the distribution is there
  double scale_;
  Color sun_ = kBlack, ground_ = kBlack;
};

}  // namespace tessera
