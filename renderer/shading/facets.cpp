#include "renderer/shading/facets.h"

namespace tessera {
namespace {

/// Facets smoother than this are a mirror.
constexpr double kSmoothestAlpha = 1e-4;

/// Schlick's factor as it goes with f0, at one cosine.
FacetAlbedo schlick_albedo(double cosine) {
  const double grazing = fresnel_schlick(kBlack, cosine).r;
  return {1 - grazing, grazing};
}

/// Its mean over the hemisphere, by the cosine: 2 * the integral of (1 - c)^5 c dc is 1 / 21.
constexpr FacetAlbedo kMeanSchlick{20.0 / 21, 1.0 / 21};

}  // namespace

double facet_alpha(double roughness) {
  const double alpha = roughness * roughness;
  return alpha < kSmoothestAlpha ? 0 : alpha;
}

FacetAlbedo Facets::towards(double cosine) const {
  return alpha > 0 ? facet_albedo(alpha, cosine) : schlick_albedo(cosine);
}

FacetAlbedo Facets::mean() const { return alpha > 0 ? mean_facet_albedo(alpha) : kMeanSchlick; }

Color Facets::between(const Color& f0) const {
  const double white = mean().of_white();
  if (alpha == 0 || 1 - white < kLeastLost) return kBlack;
  const Color fresnel = kMeanSchlick.of(f0);
  const auto channel = [&](double f) {
    const double rest = 1 - f * (1 - white);
    return rest > 0 ? f * f * white / rest : 0;
  };
  return Color{channel(fresnel.r), channel(fresnel.g), channel(fresnel.b)} * (1 / (1 - white));
}

}  // namespace tessera
