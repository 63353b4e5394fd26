#pragma once

#include <boost/container/static_vector.hpp>
#include <variant>

#include "renderer/shading/diffuse_lobe.h"
#include "renderer/shading/glass_lobe.h"
#include "renderer/shading/microfacet_lobe.h"
#include "renderer/shading/mirror_lobe.h"

namespace tessera {

/// Every kind of lobe: what lobe.h asks of one.
using Lobe = std::variant<DiffuseLobe, MicrofacetLobe, MirrorLobe, SmoothGlassLobe, RoughGlassLobe>;

/// Those of one material at one point: no material has more.
using Lobes = boost::container::static_vector<Lobe, 4>;

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

/// Whether what the material shows depends on where it is seen from: whether it has more lobes than
/// a DiffuseLobe alone, and these stand about the clamped_normal().
bool is_view_dependent(const Material& material);

/// The lobes of the point's material, with `wo` and the shading normal `normal` in their frame;
/// none where `wo` looks at the back of what depends on it. They borrow the material, which has to
/// live longer:
///
///   classic     Lambert; the highlight as GGX facets of alpha = sqrt(2 / (shininess + 2)) that
///               reflect `specular`, with what goes on between them; mirror; smooth glass. Scaled
///               down where these exceed 1.
///   physical    glTF 2.0, appendix B: by `metallic` a mix of a metal and a dielectric, which is
///               facets over a Lambert base or glass, the base getting what the facets leave it; on
///               the share `clearcoat` of it a coat (coat.h). A base colour above 1 is scaled down.
///   conductor   facets, or a mirror where roughness is 0.
///   dielectric  smooth or rough glass, or a thin sheet of it.
Lobes lobes_of(const BsdfPoint& point, const Vec3& wo, const Vec3& normal);

}  // namespace tessera
