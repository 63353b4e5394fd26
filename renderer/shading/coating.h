#pragma once

#include "renderer/math/vec.h"
#include "renderer/shading/coat.h"
#include "renderer/shading/facets.h"

namespace tessera {

/// The clear coat over the lobes of one point, as light passes it on its way to them and to the
/// viewer. By default there is none.
class Coating {
 public:
  Coating() = default;
  /// A coat on `share` of the surface over facets of `under`; `wo` as in lobe.h. The viewer may
  /// be under it, in glass whose outside is coated.
  Coating(double share, double alpha, bool viewer_is_under, Facets under, const Vec3& wo);

  bool is_there() const { return share_ > 0; }
  double share() const { return share_; }
  double alpha() const { return alpha_; }
  bool viewer_is_under() const { return viewer_is_under_; }
  /// The share of the viewer's light that comes from under it, one way or another.
  double below() const { return 1 - share_ * (1 - passed_o_); }
  /// What it lets through along `cosine`.
  double passes(double cosine) const { return 1 - share_ * coat_albedo(alpha_, cosine); }
  /// Its transmittance for light from `cosine` on the far side of the glass under it.
  double before_beyond(double cosine) const { return viewer_is_under_ ? passes(cosine) : below(); }
  /// What it leaves of light from `cosine` that is scattered evenly, `mean` being mean_passed().
  double over_even(double cosine, double mean) const;
  /// The same of light that facets reflect.
  double over_facets(CoatedFacets kind, double cosine) const;
  /// What it lets through on the mean of light that facets leave to what is under them.
  double mean_passed(const UnderFacets& under) const;

 private:
  double share_ = 0, alpha_ = 0;
  bool viewer_is_under_ = false;
  Facets under_;
  double passed_o_ = 1;                    ///< towards the viewer
  double white_o_ = 1, dielectric_o_ = 1;  ///< the same of facets of either kind
};

}  // namespace tessera
