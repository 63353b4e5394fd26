#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/shading/material.h"
#include "renderer/shading/microfacet.h"
#include "tests/uniform_numbers.h"

namespace tessera {

/// Where light ends that arrives at rough glass along a cosine: the shares that leave it after one
/// reflection or refraction, and after several, on the side where it came from and on the other.
struct GlassShares {
  double back_at_once = 0, through_at_once = 0, back = 0, through = 0;
};

/// Random walks over a Smith surface of GGX facets (Heitz, Hanika, d'Eon and Dachsbacher 2016,
/// "Multiple-Scattering Microfacet BSDFs with the Smith Model"), whose facets are smooth glass.
/// Heights are even in [0, 1], which changes nothing; a path that goes through is turned over, so
/// that it always comes from above. `eta` is beyond over here, as in fresnel_dielectric().
class SmithWalk {
 public:
  SmithWalk(double eta, double alpha, uint64_t seed) : eta_(eta), alpha_(alpha), random_(seed) {}

  GlassShares shares(double cosine, int walks) {
    GlassShares sum;
    const double share = 1.0 / walks;
    for (int i = 0; i < walks; ++i) add_walk(cosine, share, sum);
    return sum;
  }

 private:
  static constexpr int kMostEvents = 1000;

  void add_walk(double cosine, double share, GlassShares& sum) {
    Vec3 way{-std::sqrt(1 - cosine * cosine), 0, -cosine};
    double height = 1, eta = eta_;
    bool is_here = true;
    for (int events = 0; events < kMostEvents; ++events) {
      const double u = random_();
      const double lambda = 1 / Ggx(alpha_).masking(way) - 1;
      if (way.z < 0) {
        height *= std::pow(u, 1 / (1 + lambda));
      } else if (u < std::pow(height, lambda)) {
        (events > 1 ? (is_here ? sum.back : sum.through)
                    : (is_here ? sum.back_at_once : sum.through_at_once)) += share;
        return;
      } else {
        height = std::min(height * std::pow(u, -1 / lambda), 1.0);
      }
      const Vec3 wo = -way, facet = Ggx(alpha_).sample_visible(wo, {random_(), random_()});
      const double between = std::clamp(dot(wo, facet), 0.0, 1.0);
      Vec3 bent;
      if (random_() >= fresnel_dielectric(between, eta) && refract(way, facet, eta, bent)) {
        way = -bent, eta = 1 / eta, height = 1 - height, is_here = !is_here;
      } else {
        way = facet * (2 * between) - wo;
      }
      way = normalize(way);
    }
  }

  double eta_, alpha_;
  UniformNumbers random_;
};

}  // namespace tessera
