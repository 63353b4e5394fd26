#include "renderer/shading/microfacet.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/math/warp.h"
#include "renderer/shading/albedo_grid.h"

namespace tessera {

namespace {

using Grid = AlbedoGrid<FacetAlbedo, 32, 32>;

FacetAlbedo integrate(double root_alpha, double cosine) {
  FacetAlbedo sum{0, 0};
  for_each_visible_facet<8, 32>(
      root_alpha, cosine, [&](const Ggx& ggx, const Vec3& wo, const Vec3& h, double weight) {
        const Vec3 wi = h * (2 * dot(wo, h)) - wo;
        if (wi.z <= 0) return;
        const double kept = weight * ggx.shadowing(wi, wo) / ggx.masking(wo);
        const double grazing = fresnel_schlick(kBlack, dot(wo, h)).r;
        sum.scale += kept * (1 - grazing);
        sum.bias += kept * grazing;
      });
  return sum;
}

/// ln of the gamma function, z >= 1, to ten digits (Stirling's series).
double log_gamma(double z) {
  double factors = 1;
  for (; z < 8; ++z) factors *= z;
  const double inverse = 1 / z, squared = inverse * inverse;
  const double rest =
      inverse * (1.0 / 12 - squared * (1.0 / 360 - squared * (1.0 / 1260 - squared / 1680)));
  constexpr double kHalfLogOfTwoPi = 0.91893853320467274178;
  return (z - 0.5) * portable::log(z) - z + kHalfLogOfTwoPi + rest - portable::log(factors);
}

const Grid& albedo_grid() {
  static const Grid grid(integrate);
  return grid;
}

}  // namespace

double Ggx::shadowing_through(const Vec3& wi, const Vec3& wo) const {
  // The beta function of 1 + either lambda. Above, where hardly any are seen, its logarithms would
  // lose their digits.
  constexpr double kMost = 1e7;
  const double i = std::min(1 + lambda(wi), kMost), o = std::min(1 + lambda(wo), kMost);
  return portable::exp(log_gamma(i) + log_gamma(o) - log_gamma(i + o));
}

double Ggx::distribution(const Vec3& h) const {
  const double a2 = alpha_ * alpha_;
  const double t = (h.x * h.x + h.y * h.y) / a2 + h.z * h.z;
  return 1 / (portable::kPi * a2 * t * t);
}

double Ggx::lambda(const Vec3& w) const {
  const double tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
  return (std::sqrt(1 + alpha_ * alpha_ * tan2) - 1) / 2;
}

Vec3 Ggx::sample_visible(const Vec3& wo, const Vec2& u) const { return sample_cap(wo, u, 1); }

Vec3 Ggx::sample_reflecting(const Vec3& wo, const Vec2& u) const {
  return sample_cap(wo, u, bound(wo));
}

double Ggx::reflecting_density(const Vec3& wo, const Vec3& h) const {
  const double length = std::sqrt(alpha_ * alpha_ * (wo.x * wo.x + wo.y * wo.y) + wo.z * wo.z);
  return distribution(h) / (2 * (bound(wo) * wo.z + length));
}

double Ggx::bound(const Vec3& wo) const {
  const double a2 = alpha_ * alpha_, s = 1 + std::sqrt(wo.x * wo.x + wo.y * wo.y), s2 = s * s;
  return (1 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

Vec3 Ggx::sample_cap(const Vec3& wo, const Vec2& u, double bound) const {
  const Vec3 stretched = normalize(Vec3{wo.x * alpha_, wo.y * alpha_, wo.z});
  const double lowest = bound * stretched.z;
  const Vec3 cap = direction_at((1 - u.y) * (1 + lowest) - lowest, u.x);
  const Vec3 h = cap + stretched;
  return normalize(Vec3{h.x * alpha_, h.y * alpha_, std::max(h.z, 0.0)});
}

FacetAlbedo facet_albedo(double alpha, double cosine) { return albedo_grid().at(alpha, cosine); }

FacetAlbedo mean_facet_albedo(double alpha) { return albedo_grid().mean(alpha); }

double microfacet_share(double alpha, const Vec3& n, const Vec3& wi, const Vec3& wo,
                        const Vec3& half) {
  const double a2 = alpha * alpha;
  // sin^2 from the cross product: 1 - cos^2 would lose all digits in a narrow highlight.
  const double t = a2 + length_squared(cross(n, half)) * (1 - a2);
  const double n_dot_l = dot(n, wi), n_dot_v = dot(n, wo);
  const double shadowing = n_dot_l * std::sqrt(a2 + (1 - a2) * n_dot_v * n_dot_v) +
                           n_dot_v * std::sqrt(a2 + (1 - a2) * n_dot_l * n_dot_l);
  return a2 / (t * t) * 0.5 / shadowing;
}

Color fresnel_schlick(const Color& f0, double cosine) {
  const double c = std::clamp(1 - cosine, 0.0, 1.0);
  const double c2 = c * c;
  return f0 + (kWhite - f0) * (c2 * c2 * c);
}

}  // namespace tessera
