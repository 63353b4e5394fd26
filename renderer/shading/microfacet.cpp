#include "renderer/shading/microfacet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/math/warp.h"

namespace tessera {

namespace {

constexpr int kAlbedoSteps = 32;

double cosine_at(int step) {
  const double x = static_cast<double>(step) / kAlbedoSteps;
  return x * x;
}

/// facet_albedo() at steps of the square roots of alpha and of the cosine; between them linear in
/// the first and the cosine itself.
struct AlbedoTable {
  std::array<std::array<FacetAlbedo, kAlbedoSteps + 1>, kAlbedoSteps + 1> at;
  std::array<FacetAlbedo, kAlbedoSteps + 1> mean;

  AlbedoTable() {
    for (int a = 0; a <= kAlbedoSteps; ++a) {
      for (int c = 0; c <= kAlbedoSteps; ++c) {
        at[a][c] = integrate(static_cast<double>(a) / kAlbedoSteps, cosine_at(c));
      }
      // 2 * the integral of cosine * what lies linearly between the steps.
      FacetAlbedo sum{0, 0};
      for (int c = 0; c < kAlbedoSteps; ++c) {
        const double from = cosine_at(c), to = cosine_at(c + 1), third = (to - from) / 3;
        const double low = third * (2 * from + to), high = third * (from + 2 * to);
        sum.scale += (low * at[a][c].scale + high * at[a][c + 1].scale);
        sum.bias += (low * at[a][c].bias + high * at[a][c + 1].bias);
      }
      mean[a] = sum;
    }
  }

  static FacetAlbedo integrate(double root_alpha, double cosine) {
    constexpr int kAround = 8, kOut = 32;
    const Ggx ggx(std::max(root_alpha * root_alpha, 1e-4));
    const double c = std::max(cosine, 1e-3);
    const Vec3 wo{std::sqrt(1 - c * c), 0, c};
    FacetAlbedo sum{0, 0};
    double weights = 0;
    for (int i = 0; i < kAround * kOut; ++i) {
      const int step = i / kAround, around = i % kAround;
      // Both sides of the plane of wo are alike. Few facets stand steep, and these lose the most:
      // the steps grow finer towards both ends.
      const double v = (step + 0.5) / kOut, part = 6 * v * (1 - v);
      const Vec3 h = ggx.sample_visible(wo, {(around + 0.5) / (2 * kAround), v * v * (3 - 2 * v)});
      const Vec3 wi = h * (2 * dot(wo, h)) - wo;
      weights += part;
      if (wi.z <= 0) continue;
      const double kept = part * ggx.shadowing(wi, wo) / ggx.masking(wo);
      const double grazing = fresnel_schlick(kBlack, dot(wo, h)).r;
      sum.scale += kept * (1 - grazing);
      sum.bias += kept * grazing;
    }
    return {sum.scale / weights, sum.bias / weights};
  }
};

const AlbedoTable& albedo_table() {
  static const AlbedoTable table;
  return table;
}

FacetAlbedo mix(const FacetAlbedo& a, const FacetAlbedo& b, double t) {
  return {a.scale + (b.scale - a.scale) * t, a.bias + (b.bias - a.bias) * t};
}

/// A step, and how far from it to the next one.
struct Step {
  int index;
  double rest;
};
/// At or below `x` in [0, 1].
Step step_at(double x) {
  const double scaled = std::clamp(x, 0.0, 1.0) * kAlbedoSteps;
  const int index = std::min(static_cast<int>(scaled), kAlbedoSteps - 1);
  return {index, scaled - index};
}
Step step_at_cosine(double cosine) {
  const int index = step_at(std::sqrt(std::max(cosine, 0.0))).index;
  const double from = cosine_at(index), to = cosine_at(index + 1);
  return {index, std::clamp((cosine - from) / (to - from), 0.0, 1.0)};
}

}  // namespace

double Ggx::distribution(const Vec3& h) const {
  const double a2 = alpha_ * alpha_;
  const double t = (h.x * h.x + h.y * h.y) / a2 + h.z * h.z;
  return 1 / (portable::kPi * a2 * t * t);
}

double Ggx::lambda(const Vec3& w) const {
  const double tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
  return (std::sqrt(1 + alpha_ * alpha_ * tan2) - 1) / 2;
}

Vec3 Ggx::sample_visible(const Vec3& wo, const Vec2& u) const {
  const Vec3 stretched = normalize(Vec3{wo.x * alpha_, wo.y * alpha_, wo.z});
  const Vec3 cap = direction_at((1 - u.y) * (1 + stretched.z) - stretched.z, u.x);
  const Vec3 h = cap + stretched;
  return normalize(Vec3{h.x * alpha_, h.y * alpha_, std::max(h.z, 0.0)});
}

FacetAlbedo facet_albedo(double alpha, double cosine) {
  const AlbedoTable& table = albedo_table();
  const Step a = step_at(std::sqrt(alpha)), c = step_at_cosine(cosine);
  const auto along = [&](int row) {
    return mix(table.at[row][c.index], table.at[row][c.index + 1], c.rest);
  };
  return mix(along(a.index), along(a.index + 1), a.rest);
}

FacetAlbedo mean_facet_albedo(double alpha) {
  const AlbedoTable& table = albedo_table();
  const Step a = step_at(std::sqrt(alpha));
  return mix(table.mean[a.index], table.mean[a.index + 1], a.rest);
}

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
