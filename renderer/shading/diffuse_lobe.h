#pragma once

#include <algorithm>

#include "renderer/math/warp.h"
#include "renderer/shading/coating.h"
#include "renderer/shading/facets.h"
#include "renderer/shading/lambert.h"
#include "renderer/shading/lobe.h"

namespace tessera {

/// What scatters evenly: a Lambert base, alone or under facets and coat, and what goes on between
/// those facets. It stands about the shading normal.
class DiffuseLobe {
 public:
  /// What is above the base.
  struct Above {
    Facets facets{};
    FacetAlbedo facets_o{};    ///< theirs towards the viewer
    bool leaves_less = false;  ///< the base gets what `under` says; else all
    UnderFacets under{};
    Coating coat{};
    double coat_over_base = 1, coat_over_between = 1;  ///< Coating::mean_passed() of either
  };

  DiffuseLobe(const Color& base, const Vec3& normal) : base_(base), normal_(normal) { weigh(); }
  /// `base` and `between` are divided by the means of what is above leaves them.
  DiffuseLobe(const Color& base, const Color& between, const Vec3& normal, const Above& above)
      : base_(base), between_(between), normal_(normal), above_(above), is_under_(true) {
    if (above.leaves_less) left_o_ = above.under.left(above.facets_o);
    weigh();
  }

  double sampling_weight() const { return weight_; }
  static constexpr bool is_specular() { return false; }
  BsdfValue evaluate(const Vec3& wi, bool is_transmitted) const {
    const double cosine = dot(wi, normal_);
    if (is_transmitted || !(cosine > 0)) return {};
    const double density = cosine_density(cosine);
    return {albedo(cosine) * density, density};
  }
  bool sample(double, const Vec2& u, LobeSample& sample) const {
    sample.wi = cosine_hemisphere_point(u);
    if (!(sample.wi.z > 0)) return false;
    if (!is_under_) sample.weight = base_;
    if (normal_.z != 1) sample.wi = Frame(normal_).from_local(sample.wi);
    return true;
  }

 private:
  /// Of light from `cosine`.
  Color albedo(double cosine) const {
    if (!is_under_) return base_;
    const FacetAlbedo i = above_.facets.towards(cosine);
    const double lost = (1 - above_.facets_o.of_white()) * (1 - i.of_white());
    const double left = above_.leaves_less ? left_o_ * above_.under.left(i) : 1;
    return between_ * (lost * above_.coat.over_even(cosine, above_.coat_over_between)) +
           base_ * (left * above_.coat.over_even(cosine, above_.coat_over_base));
  }
  void weigh() {
    constexpr double kUsualCosine = 0.6;
    weight_ = std::max(max_component(albedo(kUsualCosine)) * above_.coat.below(), 1e-3);
  }

  Color base_, between_ = kBlack;
  Vec3 normal_;
  Above above_;
  bool is_under_ = false;
  double left_o_ = 1;
  double weight_ = 0;
};

}  // namespace tessera
