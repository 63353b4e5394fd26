#include "renderer/shading/bsdf.h"

#include <algorithm>

#include "renderer/math/warp.h"
#include "renderer/shading/glass_albedo.h"

namespace tessera {

namespace {

constexpr double kInversePi = 1 / portable::kPi;
/// Facets smoother than this are a mirror.
constexpr double kSmoothestAlpha = 1e-4;
const Color kCoatReflectance = kWhite * 0.04;

double alpha_of(double roughness) {
  const double alpha = roughness * roughness;
  return alpha < kSmoothestAlpha ? 0 : alpha;
}

Color operator/(const Color& a, const Color& b) {
  const auto ratio = [](double x, double y) { return y > 0 ? x / y : 0; };
  return {ratio(a.r, b.r), ratio(a.g, b.g), ratio(a.b, b.b)};
}

/// The mean over the hemisphere, by the cosine, of Schlick's factor: 2 * the integral of
/// (1 - c)^5 c dc is 1 / 21.
Color mean_schlick(const Color& f0) { return f0 + (kWhite - f0) * (1.0 / 21); }

}  // namespace

bool LambertBsdf::sample(double, const Vec2& u, BsdfSample& sample) const {
  const Vec3 local = cosine_hemisphere_point(u);
  sample.wi = Frame(normal_).from_local(local);
  sample.weight = albedo_;
  sample.density = local.z * kInversePi;
  sample.radiance_scale = 1;
  sample.is_mirror = sample.is_beyond = false;
  return local.z > 0 && dot(sample.wi, facet_) > 0;
}

Bsdf::Bsdf(const BsdfPoint& point)
    : frame_(dot(point.normal, point.wo) > 0 ? point.normal : point.geometric_normal),
      facet_normal_(point.geometric_normal),
      from_inside_(point.from_inside) {
  wo_ = frame_.to_local(point.wo);
  const Material& material = point.material;
  const double index = material.refractive_index;
  thin_ = material.thin;
  eta_ = point.from_inside && !thin_ ? 1 / index : index;
  switch (material.model) {
    case MaterialModel::unlit:
      break;
    case MaterialModel::classic:
      set_classic(point);
      break;
    case MaterialModel::physical:
      set_physical(point);
      break;
    case MaterialModel::conductor:
      set_conductor(material);
      break;
    case MaterialModel::dielectric:
      set_glass(material, 1, material.roughness);
      break;
  }
  set_probabilities();
}

void Bsdf::set_classic(const BsdfPoint& point) {
  const Material& material = point.material;
  const bool refracts = material.transmission == Transmission::refract && material.transparency > 0;
  const double kept = refracts ? 1 - material.transparency : 1;
  const Color diffuse = point.diffuse * kept;
  const double all = max_component(diffuse + material.specular + material.reflectivity) +
                     (refracts ? material.transparency : 0);
  const double scale = all > 1 ? 1 / all : 1;
  mirror_ = material.reflectivity * scale;
  if (refracts) set_glass(material, material.transparency * scale, 0);
  if (is_black(material.specular)) {
    diffuse_ = diffuse * scale;
    return;
  }
  // Facets that reflect the same at every angle.
  has_facets_ = true;
  alpha_ = std::min(std::sqrt(2 / (material.shininess + 2)), 1.0);
  f0_ = material.specular * scale;
  diffuse_ = diffuse * scale;
}

void Bsdf::set_physical(const BsdfPoint& point) {
  const Material& material = point.material;
  const double through = material.transparency * (1 - material.metallic);
  if (through > 0) set_glass(material, through, material.roughness);
  const double r = (material.refractive_index - 1) / (material.refractive_index + 1);
  has_facets_ = true;
  alpha_ = alpha_of(material.roughness);
  f0_ = kWhite * (r * r * (1 - material.metallic)) + point.diffuse * material.metallic;
  mean_fresnel_ = mean_schlick(f0_);
  if (material.clearcoat > 0) {
    coat_ = material.clearcoat;
    coat_alpha_ = alpha_of(material.clearcoat_roughness);
    under_coat_ = point.from_inside && through > 0 && !thin_;
  }
  add_base(point.diffuse * (1 - material.metallic));
  const double kept = 1 - glass_;
  diffuse_ = diffuse_ * kept;
  between_ = between_ * kept;
  if (alpha_ == 0) mirror_ = fresnel_schlick(f0_, wo_.z) * kept;
}

void Bsdf::set_conductor(const Material& material) {
  has_facets_ = true;
  conductor_ = &material;
  alpha_ = alpha_of(material.roughness);
  if (alpha_ == 0) {
    mirror_ = fresnel_conductor(wo_.z, material.eta, material.k);
    return;
  }
  f0_ = fresnel_conductor(1, material.eta, material.k);
  mean_fresnel_ = mean_schlick(f0_);
  add_base(kBlack);
}

void Bsdf::set_glass(const Material& material, double share, double roughness) {
  glass_ = share;
  // What bends nothing has no facets to be seen.
  const bool bends = std::abs(eta_ - 1) > 1e-4;
  glass_alpha_ = thin_ || !bends ? 0 : alpha_of(roughness);
  tint_ = transmission_tint(material);
  if (glass_alpha_ == 0 || !material.glass_albedo || !(wo_.z > 0)) return;
  glass_albedo_ = material.glass_albedo;
  between_glass_ = std::max(glass_albedo_->lost(from_inside_, glass_alpha_, wo_.z), 0.0);
  goes_through_ = glass_albedo_->through(from_inside_, glass_alpha_);
}

void Bsdf::add_base(const Color& diffuse) {
  if (alpha_ == 0) {
    const Color mean = mean_fresnel_;
    diffuse_ = diffuse / (kWhite - mean);
    return;
  }
  facets_o_ = facet_albedo(alpha_, wo_.z);
  facets_mean_ = mean_facet_albedo(alpha_);
  const FacetAlbedo& mean = facets_mean_;
  const double white = mean.of_white();
  const Color again = mean_fresnel_ * (1 - white);
  if (white < 1 - 1e-9) {
    between_ = (mean_fresnel_ * mean_fresnel_ * white / (kWhite - again)) * (1 / (1 - white));
  }
  const Color of_facets = mean.of(f0_) + between_ * ((1 - white) * (1 - white));
  diffuse_ = diffuse / (kWhite - of_facets);
}

Color Bsdf::facet_fresnel(double cosine) const {
  if (conductor_) return fresnel_conductor(std::min(cosine, 1.0), conductor_->eta, conductor_->k);
  return is_black(mean_fresnel_) ? f0_ : fresnel_schlick(f0_, cosine);
}

Color Bsdf::base(double cos_i) const {
  if (!has_facets_ || is_black(mean_fresnel_)) return diffuse_;
  if (alpha_ == 0) {
    return diffuse_ * (kWhite - fresnel_schlick(f0_, wo_.z)) *
           (kWhite - fresnel_schlick(f0_, cos_i));
  }
  const FacetAlbedo& o = facets_o_;
  const FacetAlbedo i = facet_albedo(alpha_, cos_i);
  const double mean = 1 - facets_mean_.of_white();
  const double lost_o = 1 - o.of_white(), lost_i = 1 - i.of_white();
  Color sum = between_ * (lost_o * lost_i);
  if (!is_black(diffuse_)) {
    sum += diffuse_ * (kWhite - o.of(f0_) - between_ * (lost_o * mean)) *
           (kWhite - i.of(f0_) - between_ * (lost_i * mean));
  }
  return sum;
}

double Bsdf::coat_passes(double cosine) const {
  if (coat_ == 0 || under_coat_) return 1;
  return 1 - coat_ * coat_albedo(cosine);
}

double Bsdf::coat_over_glass(double cos_i, bool beyond) const {
  if (under_coat_) return beyond ? 1 - coat_ * coat_albedo(cos_i) : 1;
  return beyond ? coat_passes(wo_.z) : coat_passes(wo_.z) * coat_passes(cos_i);
}

double Bsdf::coat_albedo(double cosine) const {
  const Color reflected = coat_alpha_ > 0 ? facet_albedo(coat_alpha_, cosine).of(kCoatReflectance)
                                          : fresnel_schlick(kCoatReflectance, cosine);
  return reflected.r;
}

void Bsdf::set_probabilities() {
  const double below = coat_passes(wo_.z);
  const auto kept = [&](const Color& c) { return max_component(c) * below; };
  if (!is_black(diffuse_) || !is_black(between_)) {
    p_base_ = std::max(kept(base(0.6)), 1e-3);
  }
  if (has_facets_ && alpha_ > 0) p_facets_ = std::max(kept(facet_fresnel(wo_.z)), 1e-3);
  p_mirror_ = kept(mirror_);
  p_glass_ = glass_ * below;
  if (coat_ > 0 && !under_coat_) (coat_alpha_ > 0 ? p_coat_ : p_coat_mirror_) = 1 - below;
  const double sum = p_base_ + p_facets_ + p_mirror_ + p_glass_ + p_coat_ + p_coat_mirror_;
  if (!(sum > 0)) return;
  for (double* p : {&p_base_, &p_facets_, &p_mirror_, &p_glass_, &p_coat_, &p_coat_mirror_}) {
    *p /= sum;
  }
}

BsdfValue Bsdf::evaluate(const Vec3& world_wi) const {
  const Vec3 wi = frame_.to_local(world_wi);
  // Bent normals let no light through the surface that they stand for.
  if ((dot(world_wi, facet_normal_) > 0) != (wi.z > 0)) return {};
  return evaluate_local(wi);
}

BsdfValue Bsdf::evaluate_local(const Vec3& wi) const {
  BsdfValue value;
  if (wi.z == 0 || !(wo_.z > 0)) return value;
  if (wi.z > 0) {
    if (p_base_ > 0) {
      value.share += base(wi.z) * (wi.z * kInversePi);
      value.density += p_base_ * wi.z * kInversePi;
    }
    const Vec3 half = normalize(wi + wo_);
    const double cosine = dot(wo_, half);
    if (p_facets_ > 0) {
      const Ggx ggx(alpha_);
      const double d = ggx.distribution(half);
      const double kept = is_black(mean_fresnel_) ? 1 : 1 - glass_;
      value.share += facet_fresnel(cosine) * (kept * d * ggx.shadowing(wi, wo_) / (4 * wo_.z));
      value.density += p_facets_ * d * ggx.masking(wo_) / (4 * wo_.z);
    }
    if (coat_ > 0) value.share = value.share * (coat_passes(wi.z) * coat_passes(wo_.z));
    if (p_coat_ > 0) {
      const Ggx ggx(coat_alpha_);
      const double d = ggx.distribution(half);
      value.share += fresnel_schlick(kCoatReflectance, cosine) *
                     (coat_ * d * ggx.shadowing(wi, wo_) / (4 * wo_.z));
      value.density += p_coat_ * d * ggx.masking(wo_) / (4 * wo_.z);
    }
  }
  if (is_rough_glass()) {
    const BsdfValue glass = evaluate_glass(wi);
    value.share += glass.share;
    value.density += glass.density;
  }
  return value;
}

BsdfValue Bsdf::evaluate_glass(const Vec3& wi) const {
  BsdfValue value = evaluate_glass_facets(wi);
  if (between_glass_ == 0) return value;
  value.density *= 1 - between_glass_;
  const bool beyond = wi.z < 0, there = from_inside_ != beyond;
  const double cosine = std::abs(wi.z);
  const double way = beyond ? goes_through_ : 1 - goes_through_;
  value.density += p_glass_ * between_glass_ * way * cosine * kInversePi;
  const double lost = std::max(glass_albedo_->lost(there, glass_alpha_, cosine), 0.0);
  const double share = glass_ * coat_over_glass(cosine, beyond) * between_glass_ * way * lost /
                       glass_albedo_->mean_lost(there, glass_alpha_) * cosine * kInversePi;
  value.share += beyond ? tint_ * (share / (eta_ * eta_)) : kWhite * share;
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
  const double d = ggx.distribution(half), g = ggx.shadowing(wi, wo_);
  const double visible = ggx.masking(wo_) * o * d / wo_.z;
  const double passes = coat_over_glass(std::abs(wi.z), beyond);
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

bool Bsdf::sample_smooth_glass(double choice, BsdfSample& sample, Vec3& wi) const {
  double fresnel = fresnel_dielectric(std::min(wo_.z, 1.0), eta_);
  // Both faces of a sheet reflect, and what is between them does so again and again.
  if (thin_) fresnel = 2 * fresnel / (1 + fresnel);
  const double weight = glass_ / p_glass_;
  sample.is_mirror = true;
  if (choice < fresnel) {
    wi = {-wo_.x, -wo_.y, wo_.z};
    sample.weight = kWhite * (weight * coat_over_glass(wo_.z, false));
    return true;
  }
  sample.is_beyond = true;
  wi = -wo_;
  if (!thin_ && !refract(-wo_, {0, 0, 1}, eta_, wi)) return false;
  sample.weight = tint_ * (weight * coat_over_glass(-wi.z, true));
  if (thin_) return true;
  sample.radiance_scale = 1 / (eta_ * eta_);
  sample.weight = sample.weight * sample.radiance_scale;
  return true;
}

bool Bsdf::sample_rough_glass(double choice, const Vec2& u, Vec3& wi) const {
  if (choice < between_glass_) {
    wi = cosine_hemisphere_point(u);
    if (choice < between_glass_ * goes_through_) wi.z = -wi.z;
    return true;
  }
  choice = (choice - between_glass_) / (1 - between_glass_);
  const Vec3 half = Ggx(glass_alpha_).sample_visible(wo_, u);
  const double cosine = std::clamp(dot(wo_, half), 0.0, 1.0);
  if (choice < fresnel_dielectric(cosine, eta_)) {
    wi = half * (2 * cosine) - wo_;
    return wi.z > 0;
  }
  return refract(-wo_, half, eta_, wi) && wi.z < 0;
}

bool Bsdf::sample(double choice, const Vec2& u, BsdfSample& sample) const {
  if (!(wo_.z > 0)) return false;
  sample.radiance_scale = 1;
  sample.is_mirror = sample.is_beyond = false;
  Vec3 wi;
  const auto takes = [&](double probability) {
    if (choice < probability) {
      choice /= probability;
      return true;
    }
    choice -= probability;
    return false;
  };
  const auto mirrored = [&](const Color& weight) {
    wi = {-wo_.x, -wo_.y, wo_.z};
    sample.weight = weight;
    sample.is_mirror = true;
  };
  const auto off_facets = [&](double alpha) {
    const Vec3 half = Ggx(alpha).sample_visible(wo_, u);
    wi = half * (2 * dot(wo_, half)) - wo_;
    return wi.z > 0;
  };
  if (takes(p_base_)) {
    wi = cosine_hemisphere_point(u);
  } else if (takes(p_facets_)) {
    if (!off_facets(alpha_)) return false;
  } else if (takes(p_coat_)) {
    if (!off_facets(coat_alpha_)) return false;
  } else if (takes(p_mirror_)) {
    mirrored(mirror_ * (coat_passes(wo_.z) * coat_passes(wo_.z) / p_mirror_));
  } else if (takes(p_coat_mirror_)) {
    mirrored(fresnel_schlick(kCoatReflectance, wo_.z) * (coat_ / p_coat_mirror_));
  } else if (p_glass_ > 0 && glass_alpha_ == 0) {
    choice = std::min(choice / p_glass_, 0x1.fffffffffffffp-1);
    if (!sample_smooth_glass(choice, sample, wi)) return false;
  } else if (!(p_glass_ > 0) || !sample_rough_glass(choice / p_glass_, u, wi)) {
    return false;
  }
  sample.wi = frame_.from_local(wi);
  sample.is_beyond = wi.z < 0;
  if ((dot(sample.wi, facet_normal_) > 0) != (wi.z > 0)) return false;
  if (sample.is_mirror) return true;
  const BsdfValue value = evaluate_local(wi);
  if (!(value.density > 0)) return false;
  if (sample.is_beyond) sample.radiance_scale = 1 / (eta_ * eta_);
  sample.weight = value.share * (1 / value.density);
  sample.density = value.density;
  return true;
}

}  // namespace tessera
