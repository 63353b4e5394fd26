#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/math/color.h"
#include "renderer/shapes/surface_sampler.h"

namespace tessera {

/// A surface that shines the same everywhere, as a light: one material of one instance.
struct AreaLight {
  std::shared_ptr<const SurfaceSampler> sampler;
  uint32_t instance = 0;
  uint32_t material = 0;                ///< LocalSurface::material of its points
  Color front = kBlack, back = kBlack;  ///< radiance towards either side
};

/// Picks lights by their power. Surfaces that cannot be chosen from (endless, of a shape without a
/// sampler, textured light) are in no set: paths find them by themselves. Immutable once built.
class AreaLights {
 public:
  /// In ascending order of instance.
  void add(AreaLight light);
  bool empty() const { return lights_.empty(); }
  size_t size() const { return lights_.size(); }
  const AreaLight& operator[](uint32_t index) const { return lights_[index]; }

  struct Pick {
    uint32_t index = 0;
    double probability = 1;
  };
  /// The one that `u`, uniform in [0, 1), chooses; not of an empty set.
  Pick pick(double u) const;
  double probability(uint32_t index) const;
  /// The light that a surface is.
  std::optional<uint32_t> find(uint32_t instance, uint32_t material) const;

 private:
  std::vector<AreaLight> lights_;
  std::vector<double> sums_;  ///< of powers up to and with each
};

}  // namespace tessera
