#pragma once

#include <array>
#include <memory>
#include <vector>

#include "renderer/shading/background.h"

namespace tessera {

/// Chooses directions in which a background is bright: cells of equal solid angle by the mean of
/// what is seen in them, and the sun. Immutable once built; thread-safe.
class EnvironmentSampler {
 public:
  struct Sample {
    Vec3 wi;             ///< unit
    double density = 0;  ///< per steradian; 0: none
  };
  explicit EnvironmentSampler(const Background& background);
  Sample sample(const Vec2& u) const;
  double density(const Vec3& direction) const;
  bool is_dark() const { return total_ + sun_ <= 0; }

 private:
  Sample sample_cells(const Vec2& u) const;
  double cell_density(const Vec3& direction) const;
  double sun_share() const { return sun_ / (sun_ + total_); }

  std::shared_ptr<const Sky> daylight_;  ///< where there is a sun
  std::array<Vec3, 3> rotation_;
  double sun_ = 0;
  std::vector<double> rows_;   ///< sums up to and with each row
  std::vector<double> cells_;  ///< the same of cells, from the start of each row
  double total_ = 0;
};

/// Null where directions spread evenly do as well: nothing but smooth colours.
std::shared_ptr<const EnvironmentSampler> make_environment_sampler(const Background& background);

}  // namespace tessera
