#pragma once

#include <memory>
#include <vector>

#include "renderer/shading/background.h"

namespace tessera {

/// Chooses the sun, and directions by how far a background is brighter there than twice its mean.
/// The rest is left to the directions that surfaces scatter to: both together find light with less
/// noise than where this one goes everywhere (Karlik et al. 2019, "MIS Compensation"; they take the
/// mean off, once). The density is bilinear between the texels of a panorama, as their light is, or
/// between points of a grid of equal solid angles. Immutable once built; thread-safe.
class EnvironmentSampler {
 public:
  struct Sample {
    Vec3 wi;             ///< unit
    double density = 0;  ///< per steradian; 0: none
  };
  explicit EnvironmentSampler(const Background& background, int threads = 1);
  /// `u` in [0, 1).
  Sample sample(const Vec2& u) const;
  /// Per steradian; 0 where sample() never goes. `place`: that of Background::place_in_panorama(),
  /// where it is known.
  double density(const Vec3& direction, const Vec2* place = nullptr) const;
  /// Whether nothing is that much brighter than the rest.
  bool is_even() const { return total_ + sun_ <= 0; }

 private:
  void look_around(int threads);
  Color seen_at(double s, double t) const;
  void leave_the_even();
  void sum_up();
  /// The patch between four points: rows from the zenith, columns from s of the first point.
  struct Patch {
    size_t row, column;
    double down, right;  ///< into it, from 0 to 1
  };
  struct Corners {
    double top_left, top_right, bottom_left, bottom_right;
  };
  Corners corners(size_t row, size_t column) const;
  Patch patch_at(const Vec3& turned, const Vec2& place) const;
  Vec3 direction_in(const Patch& patch) const;
  double point(size_t row, size_t column) const { return points_[row * columns_ + column]; }
  Sample sample_patches(const Vec2& u) const;
  double patch_density(const Vec3& turned, const Vec2* place = nullptr) const;
  double sun_share() const { return sun_ / (sun_ + total_); }
  Vec3 turned(const Vec3& direction) const;
  Vec3 in_world(const Vec3& turned) const;

  Background background_;  ///< without what depends on the place, and the sun's disc
  bool has_sun_ = false;
  double sun_ = 0;  ///< brightness times solid angle
  size_t columns_ = 0, rows_ = 0;
  std::vector<float> points_;  ///< the brightness sampled by, a row after the other
  std::vector<double>
      heights_;  ///< y of where patches begin and end: there is one more row of these
  std::vector<double> by_row_;  ///< sums of brightness times solid angle, up to and with each row
  std::vector<double> in_row_;  ///< the same of patches, from the start of each row, less factors
  double total_ = 0;
};

/// Null where directions spread evenly do as well: nothing but smooth colours.
std::shared_ptr<const EnvironmentSampler> make_environment_sampler(const Background& background,
                                                                   int threads = 1);

}  // namespace tessera
