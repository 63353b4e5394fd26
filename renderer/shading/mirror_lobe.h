#pragma once

#include "renderer/shading/lambert.h"
#include "renderer/shading/lobe.h"

namespace tessera {

/// An ideal mirror.
class MirrorLobe {
 public:
  /// That reflects `share`; `weight` is how often it is chosen beside other lobes.
  MirrorLobe(const Vec3& wo, const Color& share, double weight)
      : wo_(wo), share_(share), weight_(weight) {}

  double sampling_weight() const { return weight_; }
  static constexpr bool is_specular() { return true; }
  BsdfValue evaluate(const Vec3&, bool) const { return {}; }
  bool sample(double, const Vec2&, LobeSample& sample) const {
    sample.wi = {-wo_.x, -wo_.y, wo_.z};
    sample.weight = share_;
    return true;
  }

 private:
  Vec3 wo_;
  Color share_;
  double weight_;
};

}  // namespace tessera
