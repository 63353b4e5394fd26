#pragma once

#include <array>

#include "renderer/math/frame.h"
#include "renderer/shading/clamped_normal.h"
#include "renderer/shading/lambert.h"
#include "renderer/shading/lobes.h"

namespace tessera {

/// A direction to go on in.
struct BsdfSample {
  Vec3 wi;                      ///< unit, from the surface
  Color weight;                 ///< BSDF * |cosine| / density
  double density = 0;           ///< of all ways to choose it; not read where `is_specular`
  double radiance_scale = 1;    ///< what of `weight` only says that radiance is denser in a medium
  bool is_specular = false;     ///< there was no other way to go
  bool is_transmitted = false;  ///< it leaves on the other side than the viewer's
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
    sample.is_specular = sample.is_transmitted = false;
    return goes_on;
  }
};

/// How a material scatters light at one point: its lobes, of which a direction is chosen by one,
/// and evaluated by all. So it gives back no more than it gets and the same from either side
/// (Helmholtz), roughness and normals that are not the true ones apart. What a lobe sends to the
/// wrong side of the surface is mirrored at it, so that normals lose no light.
class Bsdf {
 public:
  explicit Bsdf(const BsdfPoint& point);

  /// Whether evaluate() can be anything but black.
  bool is_smooth() const { return is_smooth_; }
  BsdfValue evaluate(const Vec3& wi) const;
  /// `choice` and `u` are uniform in [0, 1). False where the path ends.
  bool sample(double choice, const Vec2& u, BsdfSample& sample) const;

 private:
  /// Evaluates the two directions that end as `world_wi`: itself, and the one that is mirrored into
  /// it at the surface. `wi` is `world_wi` in the frame.
  BsdfValue evaluate_on_side(const Vec3& wi, const Vec3& world_wi, bool is_transmitted) const;
  BsdfValue evaluate_lobes(const Vec3& wi, bool is_transmitted) const;

  Frame frame_;  ///< of the lobes
  Vec3 facet_normal_;
  bool leans_;  ///< the shading normal does: what is sent to the wrong side is mirrored
  bool is_smooth_ = false;
  Lobes lobes_;
  std::array<double, Lobes::static_capacity> probabilities_{};  ///< one a lobe, of their choice
};

}  // namespace tessera
