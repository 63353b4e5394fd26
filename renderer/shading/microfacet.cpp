#include "renderer/shading/microfacet.h"

#include <algorithm>
#include <cmath>

namespace tessera {

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
