#include "renderer/shading/glass_lobe.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

/// Where dielectrics reflect about what they do on the mean.
constexpr double kMeanCosine = 0.5;

}  // namespace

double GlassSide::fresnel(double cosine) const {
  const double one = fresnel_dielectric(std::min(cosine, 1.0), eta);
  return is_thin ? 2 * one / (1 + one) : one;
}

bool SmoothGlassLobe::sample(double choice, const Vec2&, LobeSample& sample) const {
  const Vec3& wo = glass_.wo;
  double fresnel = glass_.fresnel(wo.z);
  sample.wi = -wo;
  if ((glass_.is_thin || refract(-wo, {0, 0, 1}, glass_.eta, sample.wi)) &&
      glass_.coat.viewer_is_under()) {
    // What the coat turns back comes as what the glass mirrors.
    fresnel += (1 - fresnel) * (1 - glass_.coat.passes(-sample.wi.z));
  }
  if (choice < fresnel) {
    sample.wi = {-wo.x, -wo.y, wo.z};
    sample.weight = kWhite * sampling_weight();
    return true;
  }
  sample.is_transmitted = true;
  sample.radiance_scale = 1 / glass_.denser_beyond();
  sample.weight = glass_.tint * (sampling_weight() * sample.radiance_scale);
  return true;
}

RoughGlassLobe::RoughGlassLobe(const GlassSide& glass, double alpha, const GlassAlbedo* albedo)
    : glass_(glass), alpha_(alpha), albedo_(glass.is_thin ? nullptr : albedo) {
  // Facets that reflect all: what they leave is what goes on between them.
  coat_over_between_ = glass.coat.mean_passed({1, 0});
  if (!glass.is_thin && !albedo_) return;
  between_ = lost(glass.from_inside, glass.wo.z);
  if (between_ > 0) goes_through_ = lost_to(true, glass.from_inside, glass.wo.z) / between_;
  if (!albedo_ || !glass.coat.viewer_is_under()) return;
  turned_back_ = glass.coat.share() * albedo_->turned_back(glass.coat.alpha(), alpha, glass.wo.z);
  mean_turned_back_ = albedo_->mean_turned_back(glass.coat.alpha(), alpha);
}

double RoughGlassLobe::lost(bool inside, double cosine) const {
  return std::max(glass_.is_thin ? 1 - facet_albedo(alpha_, cosine).of_white()
                                 : albedo_->lost(inside, alpha_, cosine),
                  0.0);
}

double RoughGlassLobe::lost_to(bool beyond, bool inside, double cosine) const {
  const double all = lost(inside, cosine);
  const double through = glass_.is_thin ? all * (1 - glass_.fresnel(kMeanCosine))
                                        : albedo_->through(inside, alpha_, cosine);
  return beyond ? through : all - through;
}

double RoughGlassLobe::mean_lost_to(bool beyond, bool inside) const {
  const double all = glass_.is_thin ? 1 - mean_facet_albedo(alpha_).of_white()
                                    : albedo_->mean_lost(inside, alpha_);
  const double through = glass_.is_thin ? all * (1 - glass_.fresnel(kMeanCosine))
                                        : albedo_->mean_through(inside, alpha_);
  return beyond ? through : all - through;
}

BsdfValue RoughGlassLobe::evaluate(const Vec3& wi, bool is_transmitted) const {
  if (is_transmitted ? !(wi.z < 0) : !(wi.z > 0)) return {};
  BsdfValue value = glass_.is_thin ? evaluate_sheet_facets(wi) : evaluate_facets(wi);
  const double cosine = std::abs(wi.z), even = cosine_density(cosine);
  if (between_ > 0) {
    const double way = is_transmitted ? goes_through_ : 1 - goes_through_;
    value.density = value.density * (1 - between_) + between_ * way * even;
    const double coat = is_transmitted ? glass_.coat.before_beyond(cosine)
                                       : glass_.coat.over_even(cosine, coat_over_between_);
    const bool there = glass_.from_inside != is_transmitted;
    const double mean = mean_lost_to(is_transmitted, there);
    const double to = mean > 0 ? lost_to(is_transmitted, there, cosine) / mean : 0;
    const double share = glass_.share * coat * between_ * way * to * even;
    value.f_cosine +=
        is_transmitted ? glass_.tint * (share / glass_.denser_beyond()) : kWhite * share;
  }
  if (turned_back_ == 0) return value;
  value.density *= 1 - turned_back_;
  if (is_transmitted) return value;
  value.density += turned_back_ * even;
  value.f_cosine += kWhite * (glass_.share * turned_back_ *
                              albedo_->turned_back(glass_.coat.alpha(), alpha_, cosine) /
                              mean_turned_back_ * even);
  return value;
}

BsdfValue RoughGlassLobe::evaluate_facets(const Vec3& wi) const {
  const Vec3& wo = glass_.wo;
  const double eta = glass_.eta;
  const bool beyond = wi.z < 0;
  Vec3 half = beyond ? wi * eta + wo : wi + wo;
  if (length_squared(half) == 0) return {};
  half = normalize(half);
  if (half.z < 0) half = -half;
  const double o = dot(wo, half), i = dot(wi, half);
  if (o <= 0 || (i > 0) == beyond) return {};
  const Ggx ggx(alpha_);
  const double fresnel = glass_.fresnel(o), d = ggx.distribution(half);
  const double visible = ggx.masking(wo) * o * d / wo.z;
  if (!beyond) {
    const double passes = glass_.coat.over_facets(CoatedFacets::dielectric, wi.z);
    const double share = glass_.share * passes * fresnel * d * ggx.shadowing(wi, wo) / (4 * wo.z);
    return {kWhite * share, fresnel * visible / (4 * o)};
  }
  const double denominator = i + o / eta;
  const double jacobian = std::abs(i) / (denominator * denominator);
  // Radiance is denser beyond by eta^2.
  const double share = glass_.share * glass_.coat.before_beyond(-wi.z) * (1 - fresnel) * d *
                       ggx.shadowing_through(wi, wo) * o * jacobian / (wo.z * eta * eta);
  return {glass_.tint * share, (1 - fresnel) * visible * jacobian};
}

BsdfValue RoughGlassLobe::evaluate_sheet_facets(const Vec3& wi) const {
  const Vec3& wo = glass_.wo;
  const bool beyond = wi.z < 0;
  const Vec3 reflected{wi.x, wi.y, std::abs(wi.z)};
  const Vec3 half = normalize(reflected + wo);
  const double fresnel = glass_.fresnel(dot(wo, half)), way = beyond ? 1 - fresnel : fresnel;
  const Ggx ggx(alpha_);
  const double passes = beyond ? glass_.coat.before_beyond(reflected.z)
                               : glass_.coat.over_facets(CoatedFacets::dielectric, wi.z);
  const double share = glass_.share * passes * way * ggx.distribution(half) *
                       ggx.shadowing(reflected, wo) / (4 * wo.z);
  return {(beyond ? glass_.tint : kWhite) * share, way * ggx.reflecting_density(wo, half)};
}

bool RoughGlassLobe::sample(double choice, const Vec2& u, LobeSample& sample) const {
  if (!choose(choice, u, sample.wi)) return false;
  sample.is_transmitted = sample.wi.z < 0;
  if (sample.is_transmitted) sample.radiance_scale = 1 / glass_.denser_beyond();
  return true;
}

bool RoughGlassLobe::choose(double choice, const Vec2& u, Vec3& wi) const {
  const Vec3& wo = glass_.wo;
  if (choice < turned_back_) {
    wi = cosine_hemisphere_point(u);
    return true;
  }
  choice = (choice - turned_back_) / (1 - turned_back_);
  if (choice < between_) {
    wi = cosine_hemisphere_point(u);
    if (choice < between_ * goes_through_) wi.z = -wi.z;
    return true;
  }
  choice = (choice - between_) / (1 - between_);
  const Ggx ggx(alpha_);
  const Vec3 half = glass_.is_thin ? ggx.sample_reflecting(wo, u) : ggx.sample_visible(wo, u);
  const double cosine = std::clamp(dot(wo, half), 0.0, 1.0);
  const bool is_reflected = choice < glass_.fresnel(cosine);
  if (!glass_.is_thin && !is_reflected) return refract(-wo, half, glass_.eta, wi) && wi.z < 0;
  wi = half * (2 * cosine) - wo;
  if (!(wi.z > 0)) return false;
  if (!is_reflected) wi.z = -wi.z;
  return true;
}

}  // namespace tessera
