#include "renderer/shading/environment_sampler.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/parallel.h"
#include "renderer/math/elementary.h"

namespace tessera {

namespace {

constexpr size_t kLeastColumns = 256, kMostColumns = 2048;
/// How many times the mean is left to scattering. Of 0, .5, .7, .85, 1, 1.3, 1.6, 2, 3 and 5 on
/// five scenes (docs/notes/light_transport_measured.md) 1.6 and more have the least noise.
constexpr float kEvenMeans = 2;

/// How many texels a picture, or the four around a cube, has round the horizon; 0: none.
uint32_t texels_around(const Background& background) {
  uint32_t widest = 0;
  if (background.picture) widest = background.picture->settings().width;
  for (const auto& face : background.cube) {
    if (face) widest = std::max(widest, 4 * face->settings().width);
  }
  return widest;
}

/// The y of directions that place_in_panorama() takes to t.
double height_at(const Background& background, double t) {
  return background.kind == BackgroundKind::panorama_equal_area ? 1 - 2 * t
                                                                : portable::cos(portable::kPi * t);
}
/// What place_in_panorama() takes to (s, t).
Vec3 direction_at_place(const Background& background, double s, double y) {
  const double azimuth = 2 * portable::kPi * (s - 0.5) - background.angle;
  const double r = std::sqrt(std::max(0.0, 1 - y * y));
  return {r * portable::sin(azimuth), y, -r * portable::cos(azimuth)};
}

/// The number of the step that `u` of the whole falls into; `rest` is how far into it.
size_t choose(std::span<const double> sums, double u, double& rest) {
  const double at = u * sums.back();
  const auto found = std::upper_bound(sums.begin(), sums.end() - 1, at);
  const double below = found == sums.begin() ? 0 : *(found - 1);
  rest = *found > below ? std::clamp((at - below) / (*found - below), 0.0, 1.0) : 0.5;
  return static_cast<size_t>(found - sums.begin());
}

/// A place in [0, 1] of density linear from `a` to `b`.
double linear_place(double u, double a, double b) {
  const double sum = a + b;
  if (!(sum > 0)) return u;
  return std::min(u * sum / (a + std::sqrt(a * a + u * (b * b - a * a))), 1.0);
}

double between(double a, double b, double share) { return a + share * (b - a); }

}  // namespace

EnvironmentSampler::EnvironmentSampler(const Background& background, int threads)
    : background_(background) {
  background_.glow = 0;
  background_.has_sun_disc = false;
  has_sun_ = background.daylight && background.daylight->has_sun() && !background.has_cube;
  if (has_sun_) {
    const Color sun = background.daylight->sun_at_center() * (1 - background.transparency);
    sun_ = (sun.r + sun.g + sun.b) / Sky::sun_density();
  }
  look_around(threads);
  leave_the_even();
  sum_up();
}

/// Sets the grid's points to the brightness around each.
void EnvironmentSampler::look_around(int threads) {
  const uint32_t texels = texels_around(background_);
  const bool has_picture = background_.picture != nullptr;
  columns_ = has_picture ? std::min<size_t>(texels, kMostColumns)
                         : std::clamp<size_t>(texels, kLeastColumns, kMostColumns);
  const uint32_t height = has_picture ? background_.picture->settings().height : texels / 2;
  rows_ = has_picture ? std::min<size_t>(height, kMostColumns) : columns_ / 2;
  // A look between texels is at four of them.
  const auto looks = [](size_t of_texels, size_t points) {
    const size_t texels_a_point = (of_texels + points - 1) / points;
    return static_cast<int>(std::clamp<size_t>((texels_a_point + 1) / 2, 1, 8));
  };
  const int across = looks(texels, columns_), down = looks(height, rows_);
  points_.resize(rows_ * columns_);
  for_each_parallel(rows_, threads, [&](size_t row) {
    for (size_t column = 0; column < columns_; ++column) {
      double mean = 0;
      for (int i = 0; i < across * down; ++i) {
        const int right = i % across, below = i / across;
        const double s = (column + (right + 0.5) / across) / columns_;
        const double t = (row + (below + 0.5) / down) / rows_;
        const Color c = seen_at(s, t);
        mean += std::max(0.0, c.r + c.g + c.b) / (across * down);
      }
      points_[row * columns_ + column] = static_cast<float>(std::min(mean, 1e30));
    }
  });
  heights_.push_back(1);
  for (size_t row = 0; row < rows_; ++row)
    heights_.push_back(height_at(background_, (row + 0.5) / rows_));
  heights_.push_back(-1);
}

Color EnvironmentSampler::seen_at(double s, double t) const {
  if (background_.is_plain_panorama()) return background_.panorama_at(s, t);
  return background_.radiance(
      {}, in_world(direction_at_place(background_, s, height_at(background_, t))), {});
}

/// Takes off what scattering finds as well.
void EnvironmentSampler::leave_the_even() {
  sum_up();
  const auto mean = static_cast<float>((total_ + sun_) / (4 * portable::kPi));
  for (float& point : points_) point = std::max(0.0f, point - kEvenMeans * mean);
}

void EnvironmentSampler::sum_up() {
  in_row_.clear();
  by_row_.clear();
  total_ = 0;
  const double width = 2 * portable::kPi / static_cast<double>(columns_);
  for (size_t row = 0; row <= rows_; ++row) {
    double sum = 0;
    for (size_t column = 0; column < columns_; ++column) {
      const Corners c = corners(row, column);
      sum += (c.top_left + c.top_right + c.bottom_left + c.bottom_right) / 4;
      in_row_.push_back(sum);
    }
    total_ += sum * width * (heights_[row] - heights_[row + 1]);
    by_row_.push_back(total_);
  }
}

EnvironmentSampler::Corners EnvironmentSampler::corners(size_t row, size_t column) const {
  const size_t top = row > 0 ? row - 1 : 0, bottom = std::min(row, rows_ - 1);
  const size_t right = column + 1 < columns_ ? column + 1 : 0;
  return {point(top, column), point(top, right), point(bottom, column), point(bottom, right)};
}

Vec3 EnvironmentSampler::in_world(const Vec3& d) const {
  const auto& m = background_.rotation;
  return m[0] * d.x + m[1] * d.y + m[2] * d.z;
}
Vec3 EnvironmentSampler::turned(const Vec3& d) const {
  const auto& m = background_.rotation;
  return {dot(m[0], d), dot(m[1], d), dot(m[2], d)};
}

EnvironmentSampler::Sample EnvironmentSampler::sample(const Vec2& u) const {
  const double share = sun_share();
  Sample sample;
  if (u.x >= share) {
    sample = sample_patches({std::min((u.x - share) / (1 - share), 0x1.fffffffffffffp-1), u.y});
    sample.density *= 1 - share;
    if (has_sun_ && sample.density > 0 && background_.daylight->is_sun(sample.wi))
      sample.density += share * Sky::sun_density();
  } else {
    sample.wi = background_.daylight->sample_sun({u.x / share, u.y});
    sample.density = patch_density(sample.wi) * (1 - share) + share * Sky::sun_density();
  }
  sample.wi = in_world(sample.wi);
  return sample;
}

double EnvironmentSampler::density(const Vec3& direction, const Vec2* place) const {
  const double share = sun_share();
  const Vec3 d = turned(direction);
  double sum = patch_density(d, place) * (1 - share);
  if (has_sun_ && background_.daylight->is_sun(d)) sum += share * Sky::sun_density();
  return sum;
}

EnvironmentSampler::Sample EnvironmentSampler::sample_patches(const Vec2& u) const {
  double down, right;
  const size_t row = choose(by_row_, u.y, down);
  const std::span<const double> patches(in_row_.data() + row * columns_, columns_);
  if (!(patches.back() > 0)) return {};
  const size_t column = choose(patches, u.x, right);
  const Corners c = corners(row, column);
  down = linear_place(down, c.top_left + c.top_right, c.bottom_left + c.bottom_right);
  const double left = between(c.top_left, c.bottom_left, down);
  const double there = between(c.top_right, c.bottom_right, down);
  right = linear_place(right, left, there);
  return {direction_in({row, column, down, right}), between(left, there, right) / total_};
}

Vec3 EnvironmentSampler::direction_in(const Patch& patch) const {
  const double y = between(heights_[patch.row], heights_[patch.row + 1], patch.down);
  const double s = (static_cast<double>(patch.column) + 0.5 + patch.right) / columns_;
  return direction_at_place(background_, s, y);
}

EnvironmentSampler::Patch EnvironmentSampler::patch_at(const Vec3& turned,
                                                       const Vec2& place) const {
  const double last = static_cast<double>(columns_) - 1;
  double s = place.x * columns_ - 0.5;
  if (s < 0) s += columns_;
  const double column = std::min(std::floor(s), last);
  // Rounding may tell the row beside it: the density is the same on both sides.
  auto row = static_cast<size_t>(std::clamp(place.y * rows_ + 0.5, 0.0, rows_ + 0.5));
  const double span = heights_[row] - heights_[row + 1];
  return {row, static_cast<size_t>(column), std::clamp((heights_[row] - turned.y) / span, 0.0, 1.0),
          std::clamp(s - column, 0.0, 1.0)};
}

double EnvironmentSampler::patch_density(const Vec3& turned, const Vec2* place) const {
  if (!(total_ > 0)) return 0;
  const Patch at = patch_at(
      turned, place ? *place : place_in_panorama(background_.kind, background_.angle, turned));
  const Corners c = corners(at.row, at.column);
  const double left = between(c.top_left, c.bottom_left, at.down);
  const double right = between(c.top_right, c.bottom_right, at.down);
  return between(left, right, at.right) / total_;
}

std::shared_ptr<const EnvironmentSampler> make_environment_sampler(const Background& background,
                                                                   int threads) {
  const bool has_picture = background.picture != nullptr || background.has_cube ||
                           background.kind == BackgroundKind::sun_and_sky;
  if (!has_picture) return nullptr;
  auto sampler = std::make_shared<EnvironmentSampler>(background, threads);
  if (sampler->is_even()) return nullptr;
  return sampler;
}

}  // namespace tessera
