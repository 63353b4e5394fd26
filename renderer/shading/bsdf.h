#pragma once

#include "renderer/math/elementary.h"
#include "renderer/math/frame.h"
#include "renderer/math/numbers.h"
#include "renderer/math/warp.h"
#include "renderer/shading/clamped_normal.h"
#include "renderer/shading/coat.h"
#include "renderer/shading/material.h"
#include "renderer/shading/microfacet.h"

namespace tessera {

/// What a surface is where a path meets it: the material with its textures, and where it is seen
/// from.
struct BsdfPoint {
  const Material& material;
  Color diffuse;          ///< the material's, after vertex colours
  Vec3 normal;            ///< unit, for shading; may face away from the viewer
  Vec3 geometric_normal;  ///< unit, towards the viewer
  Vec3 wo;                ///< unit, to the viewer
  bool from_inside;       ///< the viewer is inside the material
};

#include "renderer/shading/lambert-inl.h"

/// A direction to go on in.
struct BsdfSample {
  Vec3 wi;                    ///< unit, from the surface
  Color weight;               ///< BSDF * |cosine| / density
  double density = 0;         ///< of all ways to choose it; not read where `is_mirror`
  double radiance_scale = 1;  ///< what of `weight` only says that radiance is denser in a medium
  bool is_mirror = false;     ///< there was no other way to go
  bool is_beyond = false;     ///< it leaves on the other side than the viewer's
};

/// Evenly scattering surfaces: the classic material without highlight, mirror or glass, which most
/// surfaces of most scenes are. The same bits as Bsdf's, faster.
class LambertBsdf : public Lambert {
 public:
  explicit LambertBsdf(const BsdfPoint& point)
      : Lambert(point.diffuse, point.normal, point.geometric_normal) {}
  bool is_smooth() const { return true; }
  bool sample(double, const Vec2& u, BsdfSample& sample) const {
    const bool goes_on = Lambert::sample(u, sample.wi, sample.density);
    sample.weight = albedo();
    sample.radiance_scale = 1;
    sample.is_mirror = sample.is_beyond = false;
    return goes_on;
  }
};

/// How a material of any model scatters light, so that it gives back no more than it gets and the
/// same from either side (Helmholtz), roughness and normals that are not the true ones apart:
///
///   classic     Lambert; the highlight as GGX facets of alpha = sqrt(2 / (shininess + 2)) that
///               reflect `specular`, with what goes on between them; mirror; smooth glass. Scaled
///               down where these exceed 1.
///   physical    glTF 2.0, appendix B: by `metallic` a mix of a metal and a dielectric, which is
///               GGX facets over a Lambert base or glass, with what is reflected between facets
///               (Kulla and Conty 2017, "Revisiting Physically Based Shading"), the base getting
///               what the facets leave it; on the share `clearcoat` of it a coat (coat.h). A base
///               colour above 1 is scaled down.
///   conductor   GGX facets, the same, or a mirror where roughness is 0.
///   dielectric  smooth or rough glass (Walter et al. 2007), the latter with what goes on between
///               its facets (Kulla and Conty again), or a thin sheet of it, whose facets let
///               light through into where they would reflect it to on the other side.
///
/// Facets, mirror and glass stand about the clamped_normal(), what lies under them about the
/// shading normal. What either sends to the wrong side of the surface is mirrored at it, so that
/// normals lose no light. A value of one point; lives while its BsdfPoint's material does.
class Bsdf {
 public:
  explicit Bsdf(const BsdfPoint& point);

  /// Whether evaluate() can be anything but black.
  bool is_smooth() const { return p_base_ + p_facets_ + p_coat_ > 0 || is_rough_glass(); }
  BsdfValue evaluate(const Vec3& wi) const;
  /// `choice` and `u` are uniform in [0, 1). False where the path ends.
  bool sample(double choice, const Vec2& u, BsdfSample& sample) const;

 private:
  void set_classic(const BsdfPoint& point);
  void set_physical(const BsdfPoint& point);
  void set_conductor(const Material& material);
  void set_glass(const Material& material, double share, double alpha, const Color& tint);
  void set_coat(const BsdfPoint& point);
  Color between_facets(const Color& f0) const;
  void set_probabilities();

  bool is_rough_glass() const { return p_glass_ > 0 && glass_alpha_ > 0; }
  Color facet_fresnel(double cosine) const;
  FacetAlbedo facets_towards(double cosine) const;
  /// What a dielectric's facets leave to what is under them.
  double left_to_diffuse(const FacetAlbedo& facets) const;
  /// What several reflections between facets and the Lambert base under them send on, times pi.
  Color base(double cos_i) const;
  /// What the coat lets through, along `cosine` and towards the viewer.
  double coat_passes(double cosine) const;
  double below_coat() const;
  /// What it leaves of light that goes through the glass.
  double coat_before_beyond(double cosine) const;
  double glass_lost(bool inside, double cosine) const;
  double glass_lost_to(bool beyond, bool inside, double cosine) const;
  double mean_glass_lost_to(bool beyond, bool inside) const;
  double sheet_fresnel(double cosine) const;
  /// What it leaves of an even base's light and of facets'.
  double coat_over_even(double cos_i, double mean) const;
  double coat_over_facets(CoatedFacets kind, double facets_o, double cos_i) const;
  /// The facets' Fresnel factor under it, `cosine` being that to their normal.
  Color coated_fresnel(double cosine, double cos_i) const;
  /// Evaluates the two directions that end as `world_wi`: itself, and the one that is mirrored into
  /// it at the surface. `wi` is `world_wi` in the frame; `is_beyond`: it is on the far side.
  BsdfValue evaluate_on_side(const Vec3& wi, const Vec3& world_wi, bool is_beyond) const;
  BsdfValue evaluate_local(const Vec3& wi, bool is_beyond) const;
  BsdfValue evaluate_glass(const Vec3& wi) const;
  BsdfValue evaluate_glass_facets(const Vec3& wi) const;
  BsdfValue evaluate_sheet_facets(const Vec3& wi) const;
  bool sample_smooth_glass(double choice, BsdfSample& sample, Vec3& wi) const;
  bool sample_rough_glass(double choice, const Vec2& u, Vec3& wi) const;

  Frame frame_;
  Vec3 facet_normal_;
  Vec3 wo_, base_normal_{0, 0, 1};  ///< in the frame
  bool leans_ = false;  ///< the shading normal does: what is sent to the wrong side is mirrored
  // Facets.
  double alpha_ = 0;  ///< 0: they are a mirror
  Color f0_ = kBlack;
  const Material* conductor_ = nullptr;
  bool has_facets_ = false;
  bool has_schlick_ = false;  ///< they reflect more by Schlick's factor
  double kept_ = 1;           ///< the share of all that is no glass
  FacetAlbedo facets_o_;      ///< towards the viewer
  Color between_ = kBlack;    ///< what is reflected between facets, over 1 - its mean
  // What is under a dielectric's.
  Color diffuse_ = kBlack;  ///< divided by what the mean of the rest is
  double dielectric_ = 0, dielectric_f0_ = 0, dielectric_between_ = 0;  ///< the share of it first
  double left_o_ = 1;  ///< what facets leave it towards the viewer
  // Clear coat.
  double coat_ = 0, coat_alpha_ = 0;
  bool under_coat_ = false;  ///< the viewer is inside glass whose outside is coated
  double coat_o_ = 1;        ///< what it lets through towards the viewer
  double coat_white_o_ = 1, coat_dielectric_o_ = 1;  ///< the same of facets of either kind
  /// What it lets through on the mean of what goes on between facets, and of what lies under them.
  double coat_between_ = 1, coat_diffuse_ = 1;
  // Glass.
  double glass_ = 0, glass_alpha_ = 0, eta_ = 1;  ///< eta beyond over that on the viewer's side
  const GlassAlbedo* glass_albedo_ = nullptr;
  bool from_inside_;
  double between_glass_ = 0;  ///< what its facets lose towards the viewer
  double goes_through_ = 0;   ///< the share of that which goes through in the end
  double turned_back_ = 0;    ///< by the coat, of light towards the viewer
  double mean_turned_back_ = 0;
  Color tint_ = kWhite;
  bool thin_ = false;
  double denser_beyond_ = 1;  ///< radiance there over that on the viewer's side
  Color mirror_ = kBlack;
  double p_base_ = 0, p_facets_ = 0, p_coat_ = 0, p_mirror_ = 0, p_coat_mirror_ = 0, p_glass_ = 0;
};

}  // namespace tessera
