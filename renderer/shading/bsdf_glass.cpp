// What of a Bsdf is glass.
#include <algorithm>

#include "renderer/math/warp.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/glass_albedo.h"

namespace tessera {
namespace {

/// Where dielectrics reflect about what they do on the mean.
constexpr double kMeanCosine = 0.5;

}  // namespace

void Bsdf::set_glass(const Material& material, double share, double alpha, const Color& tint) {
  glass_ = share;
  // What bends nothing has no facets to be seen.
  const bool bends = std::abs(eta_ - 1) > 1e-4;
  glass_alpha_ = bends ? alpha : 0;
  tint_ = tint;
  if (glass_alpha_ == 0 || !(wo_.z > 0)) return;
  if (!thin_) {
    if (!material.glass_albedo) return;
    glass_albedo_ = material.glass_albedo;
  }
  between_glass_ = glass_lost(from_inside_, wo_.z);
  if (between_glass_ > 0) goes_through_ = glass_lost_to(true, from_inside_, wo_.z) / between_glass_;
}

/// What the facets of rough glass send neither back nor through at once.
double Bsdf::glass_lost(bool inside, double cosine) const {
  if (thin_) return std::max(1 - facet_albedo(glass_alpha_, cosine).of_white(), 0.0);
  return std::max(glass_albedo_->lost(inside, glass_alpha_, cosine), 0.0);
}

/// Of that, what goes on to one side in the end.
double Bsdf::glass_lost_to(bool beyond, bool inside, double cosine) const {
  const double lost = glass_lost(inside, cosine);
  const double through = thin_ ? lost * (1 - sheet_fresnel(kMeanCosine))
                               : glass_albedo_->through(inside, glass_alpha_, cosine);
  return beyond ? through : lost - through;
}

/// Its mean over the hemisphere, by the cosine.
double Bsdf::mean_glass_lost_to(bool beyond, bool inside) const {
  const double lost = thin_ ? 1 - mean_facet_albedo(glass_alpha_).of_white()
                            : glass_albedo_->mean_lost(inside, glass_alpha_);
  const double through = thin_ ? lost * (1 - sheet_fresnel(kMeanCosine))
                               : glass_albedo_->mean_through(inside, glass_alpha_);
  return beyond ? through : lost - through;
}

/// Both faces of a sheet reflect, and what is between them does so again and again.
double Bsdf::sheet_fresnel(double cosine) const {
  const double fresnel = fresnel_dielectric(std::min(cosine, 1.0), eta_);
  return 2 * fresnel / (1 + fresnel);
}

BsdfValue Bsdf::evaluate_glass(const Vec3& wi) const {
  BsdfValue value = thin_ ? evaluate_sheet_facets(wi) : evaluate_glass_facets(wi);
  const bool beyond = wi.z < 0, there = from_inside_ != beyond;
  const double cosine = std::abs(wi.z), density = cosine * (1 / portable::kPi);
  if (between_glass_ > 0) {
    const double way = beyond ? goes_through_ : 1 - goes_through_;
    value.density =
        value.density * (1 - between_glass_) + p_glass_ * between_glass_ * way * density;
    const double coat = beyond ? coat_before_beyond(cosine) : coat_over_even(cosine, coat_between_);
    const double mean = mean_glass_lost_to(beyond, there);
    const double to = mean > 0 ? glass_lost_to(beyond, there, cosine) / mean : 0;
    const double share = glass_ * coat * between_glass_ * way * to * density;
    value.share += beyond ? tint_ * (share / denser_beyond_) : kWhite * share;
  }
  if (turned_back_ == 0) return value;
  value.density *= 1 - turned_back_;
  if (beyond) return value;
  value.density += p_glass_ * turned_back_ * density;
  value.share += kWhite * (glass_ * turned_back_ *
                           glass_albedo_->turned_back(coat_alpha_, glass_alpha_, cosine) /
                           mean_turned_back_ * density);
  return value;
}

BsdfValue Bsdf::evaluate_glass_facets(const Vec3& wi) const {
  const bool beyond = wi.z < 0;
  Vec3 half = beyond ? wi * eta_ + wo_ : wi + wo_;
  if (length_squared(half) == 0) return {};
  half = normalize(half);
  if (half.z < 0) half = -half;
  const double o = dot(wo_, half), i = dot(wi, half);
  if (o <= 0 || (i > 0) == beyond) return {};
  const Ggx ggx(glass_alpha_);
  const double fresnel = fresnel_dielectric(std::min(o, 1.0), eta_);
  const double d = ggx.distribution(half),
               g = beyond ? ggx.shadowing_through(wi, wo_) : ggx.shadowing(wi, wo_);
  const double visible = ggx.masking(wo_) * o * d / wo_.z;
  const double passes = beyond
                            ? coat_before_beyond(-wi.z)
                            : coat_over_facets(CoatedFacets::dielectric, coat_dielectric_o_, wi.z);
  if (!beyond) {
    const double share = glass_ * passes * fresnel * d * g / (4 * wo_.z);
    return {kWhite * share, p_glass_ * fresnel * visible / (4 * o)};
  }
  const double denominator = i + o / eta_;
  const double jacobian = std::abs(i) / (denominator * denominator);
  // Radiance is denser beyond by eta^2.
  const double share =
      glass_ * passes * (1 - fresnel) * d * g * o * jacobian / (wo_.z * eta_ * eta_);
  return {tint_ * share, p_glass_ * (1 - fresnel) * visible * jacobian};
}

/// A sheet's facets reflect, and let through what they do not, as if that were reflected and came
/// out on the other side (KHR_materials_transmission).
BsdfValue Bsdf::evaluate_sheet_facets(const Vec3& wi) const {
  const bool beyond = wi.z < 0;
  const Vec3 reflected{wi.x, wi.y, std::abs(wi.z)};
  const Vec3 half = normalize(reflected + wo_);
  const double fresnel = sheet_fresnel(dot(wo_, half)), way = beyond ? 1 - fresnel : fresnel;
  const Ggx ggx(glass_alpha_);
  const double d = ggx.distribution(half) / (4 * wo_.z);
  const double passes = beyond
                            ? coat_before_beyond(reflected.z)
                            : coat_over_facets(CoatedFacets::dielectric, coat_dielectric_o_, wi.z);
  const double share = glass_ * passes * way * d * ggx.shadowing(reflected, wo_);
  return {(beyond ? tint_ : kWhite) * share, p_glass_ * way * ggx.reflecting_density(wo_, half)};
}

bool Bsdf::sample_smooth_glass(double choice, BsdfSample& sample, Vec3& wi) const {
  double fresnel = thin_ ? sheet_fresnel(wo_.z) : fresnel_dielectric(std::min(wo_.z, 1.0), eta_);
  wi = -wo_;
  if ((thin_ || refract(-wo_, {0, 0, 1}, eta_, wi)) && under_coat_) {
    // What the coat turns back comes as what the glass mirrors.
    fresnel += (1 - fresnel) * (1 - coat_passes(-wi.z));
  }
  const double weight = glass_ * below_coat() / p_glass_;
  sample.is_mirror = true;
  if (choice < fresnel) {
    wi = {-wo_.x, -wo_.y, wo_.z};
    sample.weight = kWhite * weight;
    return true;
  }
  sample.is_beyond = true;
  sample.weight = tint_ * weight;
  if (thin_) return true;
  sample.radiance_scale = 1 / (eta_ * eta_);
  sample.weight = sample.weight * sample.radiance_scale;
  return true;
}

bool Bsdf::sample_rough_glass(double choice, const Vec2& u, Vec3& wi) const {
  if (choice < turned_back_) {
    wi = cosine_hemisphere_point(u);
    return true;
  }
  choice = (choice - turned_back_) / (1 - turned_back_);
  if (choice < between_glass_) {
    wi = cosine_hemisphere_point(u);
    if (choice < between_glass_ * goes_through_) wi.z = -wi.z;
    return true;
  }
  choice = (choice - between_glass_) / (1 - between_glass_);
  const Ggx ggx(glass_alpha_);
  const Vec3 half = thin_ ? ggx.sample_reflecting(wo_, u) : ggx.sample_visible(wo_, u);
  const double cosine = std::clamp(dot(wo_, half), 0.0, 1.0);
  if (thin_) {
    wi = half * (2 * cosine) - wo_;
    if (!(wi.z > 0)) return false;
    if (choice >= sheet_fresnel(cosine)) wi.z = -wi.z;
    return true;
  }
  if (choice < fresnel_dielectric(cosine, eta_)) {
    wi = half * (2 * cosine) - wo_;
    return wi.z > 0;
  }
  return refract(-wo_, half, eta_, wi) && wi.z < 0;
}

}  // namespace tessera
