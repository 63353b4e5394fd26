#include "renderer/shading/bsdf.h"

#include <algorithm>

#include "renderer/math/warp.h"
#include "renderer/shading/glass_albedo.h"

namespace tessera {

namespace {

constexpr double kInversePi = 1 / portable::kPi;
/// Facets smoother than this are a mirror.
constexpr double kSmoothestAlpha = 1e-4;
/// What less is lost between facets than this is nothing.
constexpr double kLeastLost = 1e-9;

double alpha_of(double roughness) {
  const double alpha = roughness * roughness;
  return alpha < kSmoothestAlpha ? 0 : alpha;
}

Color operator/(const Color& a, const Color& b) {
  const auto ratio = [](double x, double y) { return y > 0 ? x / y : 0; };
  return {ratio(a.r, b.r), ratio(a.g, b.g), ratio(a.b, b.b)};
}

/// Schlick's factor as it goes with f0, at one cosine.
FacetAlbedo schlick_albedo(double cosine) {
  const double grazing = fresnel_schlick(kBlack, cosine).r;
  return {1 - grazing, grazing};
}

/// Its mean over the hemisphere, by the cosine: 2 * the integral of (1 - c)^5 c dc is 1 / 21.
constexpr FacetAlbedo kMeanSchlick{20.0 / 21, 1.0 / 21};

FacetAlbedo mean_of_facets(double alpha) {
  return alpha > 0 ? mean_facet_albedo(alpha) : kMeanSchlick;
}

/// Whether what it shows depends on where it is seen from.
bool is_view_dependent(const Material& material) {
  return material.model != MaterialModel::classic || !is_black(material.specular) ||
         !is_black(material.reflectivity) ||
         (material.transmission == Transmission::refract && material.transparency > 0);
}

Vec3 normal_of_facets(const BsdfPoint& point) {
  if (!is_view_dependent(point.material)) return point.normal;
  return clamped_normal(point.normal, point.geometric_normal, point.wo);
}

}  // namespace

Bsdf::Bsdf(const BsdfPoint& point)
    : frame_(normal_of_facets(point)),
      facet_normal_(point.geometric_normal),
      from_inside_(point.from_inside) {
  wo_ = frame_.to_local(point.wo);
  leans_ = point.normal != point.geometric_normal;
  if (frame_.z != point.normal) base_normal_ = frame_.to_local(point.normal);
  if (!(wo_.z > 0) && is_view_dependent(point.material)) return;
  const Material& material = point.material;
  const double index = material.refractive_index;
  thin_ = material.thin;
  eta_ = point.from_inside && !thin_ ? 1 / index : index;
  denser_beyond_ = thin_ ? 1 : eta_ * eta_;
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
      set_glass(material, 1, alpha_of(material.roughness), kWhite);
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
  diffuse_ = diffuse * scale;
  if (refracts) set_glass(material, material.transparency * scale, 0, kWhite);
  if (is_black(material.specular)) return;
  // Facets that reflect the same at every angle, and as much of what goes on between them.
  has_facets_ = true;
  alpha_ = std::min(std::sqrt(2 / (material.shininess + 2)), 1.0);
  f0_ = material.specular * scale;
  facets_o_ = facets_towards(wo_.z);
  const double lost = 1 - mean_of_facets(alpha_).of_white();
  if (lost > kLeastLost) between_ = f0_ * (1 / lost);
}

void Bsdf::set_physical(const BsdfPoint& point) {
  const Material& material = point.material;
  const Color color = bounded(point.diffuse);
  const double metal = material.metallic;
  const double through = material.transparency * (1 - metal);
  if (through > 0) set_glass(material, through, alpha_of(material.roughness), color);
  kept_ = 1 - glass_;
  dielectric_ = kept_ - metal;
  if (kept_ > 0) {
    const double r = (material.refractive_index - 1) / (material.refractive_index + 1);
    has_facets_ = has_schlick_ = true;
    alpha_ = alpha_of(material.roughness);
    dielectric_f0_ = r * r;
    f0_ = (kWhite * (dielectric_f0_ * dielectric_) + color * metal) * (1 / kept_);
    facets_o_ = facets_towards(wo_.z);
    const Color dielectric_between = between_facets(kWhite * dielectric_f0_);
    between_ = between_facets(color) * metal + dielectric_between * dielectric_;
    const FacetAlbedo mean = mean_of_facets(alpha_);
    dielectric_between_ = dielectric_between.r * (1 - mean.of_white());
    const double left = left_to_diffuse(mean);
    if (left > kLeastLost) diffuse_ = color * (dielectric_ / left);
    left_o_ = left_to_diffuse(facets_o_);
    if (alpha_ == 0) mirror_ = fresnel_schlick(f0_, wo_.z) * kept_;
  }
  if (material.clearcoat > 0) set_coat(point);
}

void Bsdf::set_coat(const BsdfPoint& point) {
  const Material& material = point.material;
  coat_ = material.clearcoat;
  coat_alpha_ = alpha_of(material.clearcoat_roughness);
  under_coat_ = point.from_inside && glass_ > 0 && !thin_;
  const double alpha = alpha_ > 0 ? alpha_ : glass_alpha_;
  const FacetAlbedo mean = mean_of_facets(alpha);
  const CoatMeans reflected = coat_means(coat_alpha_, alpha);
  const double lost = reflected.all - reflected.scale - reflected.bias;
  const double mean_lost = 1 - mean.of_white();
  if (mean_lost > kLeastLost) coat_between_ = 1 - lost / mean_lost;
  const double left = left_to_diffuse(mean);
  const double left_light = reflected.all - reflected.scale * dielectric_f0_ - reflected.bias -
                            dielectric_between_ * lost;
  if (left > kLeastLost) coat_diffuse_ = 1 - left_light / left;
  if (!under_coat_) {
    coat_o_ = 1 - coat_albedo(coat_alpha_, wo_.z);
    coat_white_o_ = coated_facets(CoatedFacets::white, coat_alpha_, alpha, wo_.z);
    coat_dielectric_o_ = coated_facets(CoatedFacets::dielectric, coat_alpha_, alpha, wo_.z);
  } else if (glass_albedo_) {
    turned_back_ = coat_ * glass_albedo_->turned_back(coat_alpha_, glass_alpha_, wo_.z);
    mean_turned_back_ = glass_albedo_->mean_turned_back(coat_alpha_, glass_alpha_);
  }
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
  facets_o_ = facets_towards(wo_.z);
  between_ = between_facets(f0_);
}

/// What goes on between facets that reflect f0 straight on, over 1 - its mean.
Color Bsdf::between_facets(const Color& f0) const {
  const double white = mean_of_facets(alpha_).of_white();
  if (alpha_ == 0 || 1 - white < kLeastLost) return kBlack;
  const Color fresnel = kMeanSchlick.of(f0);
  return (fresnel * fresnel * white / (kWhite - fresnel * (1 - white))) * (1 / (1 - white));
}

Color Bsdf::facet_fresnel(double cosine) const {
  if (conductor_) return fresnel_conductor(std::min(cosine, 1.0), conductor_->eta, conductor_->k);
  return has_schlick_ ? fresnel_schlick(f0_, cosine) : f0_;
}

FacetAlbedo Bsdf::facets_towards(double cosine) const {
  return alpha_ > 0 ? facet_albedo(alpha_, cosine) : schlick_albedo(cosine);
}

double Bsdf::left_to_diffuse(const FacetAlbedo& facets) const {
  return 1 - facets.scale * dielectric_f0_ - facets.bias -
         dielectric_between_ * (1 - facets.of_white());
}

Color Bsdf::base(double cos_i) const {
  if (!has_facets_) return diffuse_;
  const FacetAlbedo i = facets_towards(cos_i);
  const double lost = (1 - facets_o_.of_white()) * (1 - i.of_white());
  const double left = has_schlick_ ? left_o_ * left_to_diffuse(i) : 1;
  return between_ * (lost * coat_over_even(cos_i, coat_between_)) +
         diffuse_ * (left * coat_over_even(cos_i, coat_diffuse_));
}

double Bsdf::coat_passes(double cosine) const {
  return 1 - coat_ * coat_albedo(coat_alpha_, cosine);
}

double Bsdf::below_coat() const { return 1 - coat_ * (1 - coat_o_); }

double Bsdf::coat_before_beyond(double cosine) const {
  return under_coat_ ? coat_passes(cosine) : below_coat();
}

double Bsdf::coat_over_even(double cos_i, double mean) const {
  if (coat_ == 0 || under_coat_) return 1;
  return 1 - coat_ + coat_ * coat_o_ * (1 - coat_albedo(coat_alpha_, cos_i)) / mean;
}

double Bsdf::coat_over_facets(CoatedFacets kind, double facets_o, double cos_i) const {
  if (coat_ == 0 || under_coat_) return 1;
  const double alpha = alpha_ > 0 ? alpha_ : glass_alpha_;
  return 1 - coat_ + coat_ * facets_o * coated_facets(kind, coat_alpha_, alpha, cos_i);
}

Color Bsdf::coated_fresnel(double cosine, double cos_i) const {
  const Color all = facet_fresnel(cosine) * kept_;
  if (coat_ == 0 || under_coat_) return all;
  const Color dielectric = fresnel_schlick(kWhite * dielectric_f0_, cosine) * dielectric_;
  return (all - dielectric) * coat_over_facets(CoatedFacets::white, coat_white_o_, cos_i) +
         dielectric * coat_over_facets(CoatedFacets::dielectric, coat_dielectric_o_, cos_i);
}

void Bsdf::set_probabilities() {
  const double below = below_coat();
  const auto kept = [&](const Color& c) { return max_component(c) * below; };
  if (!is_black(diffuse_) || !is_black(between_)) {
    p_base_ = std::max(kept(base(0.6)), 1e-3);
  }
  if (has_facets_ && alpha_ > 0) {
    p_facets_ = std::max(kept(facet_fresnel(wo_.z)) * facets_o_.of_white() * kept_, 1e-3);
  }
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
  const double side = dot(world_wi, facet_normal_);
  if (side == 0) return {};
  return evaluate_on_side(frame_.to_local(world_wi), world_wi, side < 0);
}

BsdfValue Bsdf::evaluate_on_side(const Vec3& wi, const Vec3& world_wi, bool is_beyond) const {
  BsdfValue value = evaluate_local(wi, is_beyond);
  if (!leans_) return value;
  const Vec3 mirrored = frame_.to_local(reflect(world_wi, facet_normal_));
  const BsdfValue folded = evaluate_local(mirrored, is_beyond);
  value.share += folded.share;
  value.density += folded.density;
  return value;
}

BsdfValue Bsdf::evaluate_local(const Vec3& wi, bool is_beyond) const {
  BsdfValue value;
  const double cosine_to_base = dot(wi, base_normal_);
  if (!is_beyond && p_base_ > 0 && cosine_to_base > 0) {
    value.share += base(cosine_to_base) * (cosine_to_base * kInversePi);
    value.density += p_base_ * cosine_to_base * kInversePi;
  }
  if (is_beyond ? !(wi.z < 0) : !(wi.z > 0)) return value;
  if (!is_beyond) {
    const Vec3 half = normalize(wi + wo_);
    const double cosine = dot(wo_, half);
    if (p_facets_ > 0) {
      const Ggx ggx(alpha_);
      const double d = ggx.distribution(half);
      value.share += coated_fresnel(cosine, wi.z) * (d * ggx.shadowing(wi, wo_) / (4 * wo_.z));
      value.density += p_facets_ * ggx.reflecting_density(wo_, half);
    }
    if (p_coat_ > 0) {
      const Ggx ggx(coat_alpha_);
      const double d = ggx.distribution(half);
      value.share += fresnel_schlick(kWhite * kCoatReflectance, cosine) *
                     (coat_ * d * ggx.shadowing(wi, wo_) / (4 * wo_.z));
      value.density += p_coat_ * ggx.reflecting_density(wo_, half);
    }
  }
  if (is_rough_glass()) {
    const BsdfValue glass = evaluate_glass(wi);
    value.share += glass.share;
    value.density += glass.density;
  }
  return value;
}

bool Bsdf::sample(double choice, const Vec2& u, BsdfSample& sample) const {
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
    const Vec3 half = Ggx(alpha).sample_reflecting(wo_, u);
    wi = half * (2 * dot(wo_, half)) - wo_;
    return wi.z > 0;
  };
  if (takes(p_base_)) {
    wi = cosine_hemisphere_point(u);
    if (!(wi.z > 0)) return false;
    if (base_normal_.z != 1) wi = Frame(base_normal_).from_local(wi);
  } else if (takes(p_facets_)) {
    if (!off_facets(alpha_)) return false;
  } else if (takes(p_coat_)) {
    if (!off_facets(coat_alpha_)) return false;
  } else if (takes(p_mirror_)) {
    mirrored(mirror_ * (below_coat() / p_mirror_));
  } else if (takes(p_coat_mirror_)) {
    mirrored(fresnel_schlick(kWhite * kCoatReflectance, wo_.z) * (coat_ / p_coat_mirror_));
  } else if (p_glass_ > 0 && glass_alpha_ == 0) {
    choice = std::min(choice / p_glass_, 0x1.fffffffffffffp-1);
    if (!sample_smooth_glass(choice, sample, wi)) return false;
  } else if (p_glass_ > 0 && sample_rough_glass(choice / p_glass_, u, wi)) {
    sample.is_beyond = wi.z < 0;
  } else {
    return false;
  }
  const Vec3 way = frame_.from_local(wi);
  sample.wi = reflected_to_side(way, facet_normal_, sample.is_beyond);
  if (dot(way, facet_normal_) == 0) return false;
  if (sample.is_mirror) return true;
  const BsdfValue value = evaluate_on_side(wi, way, sample.is_beyond);
  if (!(value.density > 0)) return false;
  if (sample.is_beyond) sample.radiance_scale = 1 / denser_beyond_;
  // Where nothing else was to choose the density cancels.
  sample.weight = p_base_ == 1 ? base(wi.z) : value.share * (1 / value.density);
  sample.density = value.density;
  return true;
}

}  // namespace tessera
