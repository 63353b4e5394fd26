#pragma once

#include "renderer/shading/coating.h"
#include "renderer/shading/glass_albedo.h"
#include "renderer/shading/lambert.h"
#include "renderer/shading/lobe.h"

namespace tessera {

/// What glass of any kind is, seen from one side.
struct GlassSide {
  Vec3 wo;                   ///< as in lobe.h
  bool from_inside = false;  ///< the viewer is in the glass
  bool is_thin = false;      ///< a sheet: what goes through is not bent
  double eta = 1;            ///< refractive index beyond over that on the viewer's side
  double share = 1;          ///< of the surface that is glass
  Color tint = kWhite;       ///< of what goes through
  Coating coat{};

  /// What a face reflects; of a sheet both, and what is between them again and again.
  double fresnel(double cosine) const;
  /// Radiance beyond over that on the viewer's side.
  double denser_beyond() const { return is_thin ? 1 : eta * eta; }
};

/// Smooth glass, or a sheet of it, under whatever coat.
class SmoothGlassLobe {
 public:
  explicit SmoothGlassLobe(const GlassSide& glass) : glass_(glass) {}

  double sampling_weight() const { return glass_.share * glass_.coat.below(); }
  static constexpr bool is_specular() { return true; }
  BsdfValue evaluate(const Vec3&, bool) const { return {}; }
  bool sample(double choice, const Vec2& u, LobeSample& sample) const;

 private:
  GlassSide glass_;
};

/// Rough glass (Walter et al. 2007) with what goes on between its facets (Kulla and Conty 2017), or
/// a thin sheet of it, whose facets let light through into where they would reflect it to on the
/// other side (KHR_materials_transmission).
class RoughGlassLobe {
 public:
  /// `alpha` > 0. `albedo` of the glass's refractive index must outlive this; null, of a sheet and
  /// where what facets lose is to be lost.
  RoughGlassLobe(const GlassSide& glass, double alpha, const GlassAlbedo* albedo);

  double sampling_weight() const { return glass_.share * glass_.coat.below(); }
  static constexpr bool is_specular() { return false; }
  BsdfValue evaluate(const Vec3& wi, bool is_transmitted) const;
  bool sample(double choice, const Vec2& u, LobeSample& sample) const;

 private:
  bool choose(double choice, const Vec2& u, Vec3& wi) const;
  /// Of what arrives along `cosine`, inside or outside: what facets send neither back nor through
  /// at once; and what of that goes on to one side in the end, and the mean of that.
  double lost(bool inside, double cosine) const;
  double lost_to(bool beyond, bool inside, double cosine) const;
  double mean_lost_to(bool beyond, bool inside) const;
  BsdfValue evaluate_facets(const Vec3& wi) const;
  BsdfValue evaluate_sheet_facets(const Vec3& wi) const;

  GlassSide glass_;
  double alpha_;
  const GlassAlbedo* albedo_;
  double coat_over_between_ = 1;  ///< Coating::mean_passed() of what goes on between facets
  double between_ = 0;            ///< what facets lose towards the viewer
  double goes_through_ = 0;       ///< the share of that which goes through in the end
  double turned_back_ = 0;        ///< by the coat, of light towards the viewer
  double mean_turned_back_ = 0;
};

}  // namespace tessera
