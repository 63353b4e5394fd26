#pragma once

#include "renderer/shading/clamped_normal.h"
#include "renderer/shading/material.h"

namespace tessera {

/// What a surface sends to the viewer of light without extent and of ambient light, by the local
/// formulas of its model (scene.proto). `kRich`: it may be another than the classic one. A value of
/// one point; lives while its material does.
template <bool kRich>
class LocalShare {
 public:
  /// `diffuse` is the material's after vertex colours, of which `kept` is not sent elsewhere; `wo`
  /// (to the viewer) and the normals, for shading and the surface's own, are of unit length.
  LocalShare(const Material& material, const Color& diffuse, double kept, const Vec3& wo,
             const Vec3& normal, const Vec3& geometric_normal)
      : material_(material), diffuse_(diffuse), kept_(kept), wo_(wo), normal_(normal) {
    if (!is_classic()) facets_ = clamped_normal(normal, geometric_normal, wo);
  }

  /// Of the radiant intensity of a light at `wi`.
  [[gnu::always_inline]] Color reflected(const Vec3& wi) const {
    if (is_classic()) return reflected_share(material_, diffuse_ * kept_, normal_, wi, wo_);
    return any_reflected_share(material_, diffuse_, normal_, facets_, wi, wo_);
  }
  Color ambient(const Color& light) const {
    if (!is_classic()) return light * ambient_share(material_, diffuse_) * kept_;
    return light * material_.ambient *
           (material_.ambient_times_diffuse ? diffuse_ * kept_ : kWhite * kept_);
  }

 private:
  bool is_classic() const { return !kRich || material_.model == MaterialModel::classic; }

  const Material& material_;
  Color diffuse_;
  double kept_;
  Vec3 wo_, normal_, facets_;
};

}  // namespace tessera
