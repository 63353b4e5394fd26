#include "renderer/shading/coating.h"

namespace tessera {

Coating::Coating(double share, double alpha, bool viewer_is_under, Facets under, const Vec3& wo)
    : share_(share), alpha_(alpha), viewer_is_under_(viewer_is_under), under_(under) {
  if (viewer_is_under) return;
  passed_o_ = 1 - coat_albedo(alpha, wo.z);
  white_o_ = coated_facets(CoatedFacets::white, alpha, under.alpha, wo.z);
  dielectric_o_ = coated_facets(CoatedFacets::dielectric, alpha, under.alpha, wo.z);
}

double Coating::over_even(double cosine, double mean) const {
  if (!is_there() || viewer_is_under_) return 1;
  return 1 - share_ + share_ * passed_o_ * (1 - coat_albedo(alpha_, cosine)) / mean;
}

double Coating::over_facets(CoatedFacets kind, double cosine) const {
  if (!is_there() || viewer_is_under_) return 1;
  const double towards_viewer = kind == CoatedFacets::white ? white_o_ : dielectric_o_;
  return 1 - share_ + share_ * towards_viewer * coated_facets(kind, alpha_, under_.alpha, cosine);
}

double Coating::mean_passed(const UnderFacets& under) const {
  if (!is_there()) return 1;
  const double left = under.left(under_.mean());
  if (!(left > kLeastLost)) return 1;
  const CoatMeans reflected = coat_means(alpha_, under_.alpha);
  const double lost = reflected.all - reflected.scale - reflected.bias;
  return 1 - (reflected.all - reflected.scale * under.f0 - reflected.bias - under.between * lost) /
                 left;
}

}  // namespace tessera
