#include "renderer/shading/sky.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/math/frame.h"
#include "renderer/math/warp.h"

namespace tessera {

namespace {

/// Perez' distribution of a quantity over the sky: `cosine` from the zenith, `gamma` from the sun.
double perez(const double (&c)[5], double cosine, double gamma) {
  const double cos_gamma = portable::cos(gamma);
  return (1 + c[0] * portable::exp(c[1] / std::max(cosine, 0.01))) *
         (1 + c[2] * portable::exp(c[3] * gamma) + c[4] * cos_gamma * cos_gamma);
}

/// CIE xyY to linear RGB with the primaries of sRGB.
Color rgb_of(double x, double y, double luminance) {
  const double X = x / y * luminance, Z = (1 - x - y) / y * luminance;
  return {3.2404542 * X - 1.5371385 * luminance - 0.4985314 * Z,
          -0.9692660 * X + 1.8760108 * luminance + 0.0415560 * Z,
          0.0556434 * X - 0.2040259 * luminance + 1.0572252 * Z};
}

Color not_negative(const Color& c) {
  return {std::max(c.r, 0.0), std::max(c.g, 0.0), std::max(c.b, 0.0)};
}

double angle_by_cosine(const Vec3& a, const Vec3& b) {
  return portable::acos(std::clamp(dot(a, b), -1.0, 1.0));
}

/// Of the sun's light, what comes through the air: Rayleigh scattering and aerosols at wavelengths
/// of red, green and blue (the paper's appendix A.2, without ozone, water and mixed gases).
Color air_transmittance(double cosine, double turbidity) {
  const double degrees = portable::degrees(portable::acos(cosine));
  const double mass = 1 / (cosine + 0.15 * portable::pow(93.885 - degrees, -1.253));
  const double beta = 0.04608 * turbidity - 0.04586;
  const auto at = [&](double micrometres) {
    const double rayleigh = portable::exp(-0.008735 * portable::pow(micrometres, -4.08) * mass);
    return rayleigh * portable::exp(-beta * portable::pow(micrometres, -1.3) * mass);
  };
  return {at(0.61), at(0.55), at(0.465)};
}

}  // namespace

Sky::Sky(const Vec3& to_sun, double turbidity, double intensity, const Color& ground_albedo)
    : to_sun_(to_sun) {
  const double T = turbidity;
  const double theta =
      std::min(portable::acos(std::clamp(to_sun.y, -1.0, 1.0)), portable::kPi / 2 - 0.01);
  const double coefficients[3][5] = {
      {0.1787 * T - 1.4630, -0.3554 * T + 0.4275, -0.0227 * T + 5.3251, 0.1206 * T - 2.5771,
       -0.0670 * T + 0.3703},
      {-0.0193 * T - 0.2592, -0.0665 * T + 0.0008, -0.0004 * T + 0.2125, -0.0641 * T - 0.8989,
       -0.0033 * T + 0.0452},
      {-0.0167 * T - 0.2608, -0.0950 * T + 0.0092, -0.0079 * T + 0.2102, -0.0441 * T - 1.6537,
       -0.0109 * T + 0.0529}};
  std::copy(&coefficients[0][0], &coefficients[0][0] + 15, &perez_[0][0]);
  const double chi = (4.0 / 9 - T / 120) * (portable::kPi - 2 * theta);
  const double t2 = theta * theta, t3 = t2 * theta;
  zenith_[0] = std::max((4.0453 * T - 4.9710) * portable::tan(chi) - 0.2155 * T + 2.4192, 0.0);
  zenith_[1] = T * T * (0.00166 * t3 - 0.00375 * t2 + 0.00209 * theta) +
               T * (-0.02903 * t3 + 0.06377 * t2 - 0.03202 * theta + 0.00394) +
               (0.11693 * t3 - 0.21196 * t2 + 0.06052 * theta + 0.25886);
  zenith_[2] = T * T * (0.00275 * t3 - 0.00610 * t2 + 0.00317 * theta) +
               T * (-0.04214 * t3 + 0.08970 * t2 - 0.04153 * theta + 0.00516) +
               (0.15346 * t3 - 0.26756 * t2 + 0.06670 * theta + 0.26688);
  for (int i = 0; i < 3; ++i) zenith_[i] /= perez(perez_[i], 1, theta);
  scale_ = intensity / 32;  // zenith luminance is in kcd/m^2
  if (to_sun.y > 0) {
    // The sun's disc beyond the air has 1.9e6 kcd/m^2.
    sun_ = air_transmittance(to_sun.y, T) * (1.9e6 * scale_);
  }
  // Irradiance on even ground, by the rule of mid-points.
  constexpr int kSteps = 16;
  Color irradiance = kBlack;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const int row = i / kSteps, column = i % kSteps;
    const double z = std::sqrt((row + 0.5) / kSteps);  // spread by the cosine
    const Vec3 d = direction_at(z, (column + 0.5) / kSteps);
    irradiance += radiance({d.x, d.z, d.y}) * (portable::kPi / (kSteps * kSteps));
  }
  irradiance += sun_ * (std::max(to_sun.y, 0.0) / sun_density());
  ground_ = ground_albedo * irradiance * (1 / portable::kPi);
}

Color Sky::radiance(const Vec3& d) const {
  if (d.y < 0) return ground_;
  const double gamma = angle_by_cosine(d, to_sun_);
  double value[3];
  for (int i = 0; i < 3; ++i) value[i] = zenith_[i] * perez(perez_[i], d.y, gamma);
  return not_negative(rgb_of(value[1], value[2], value[0] * scale_));
}

double Sky::sun_density() { return 1 / (2 * portable::kPi * (1 - kCosRadius)); }

Vec3 Sky::sample_sun(const Vec2& u) const {
  return normalize(Frame(to_sun_).from_local(direction_at(1 - u.x * (1 - kCosRadius), u.y)));
}

}  // namespace tessera
