#include "renderer/shading/environment_sampler.h"

#include <algorithm>
#include <span>

#include "renderer/math/elementary.h"
#include "renderer/math/warp.h"

namespace tessera {

namespace {

constexpr int kRows = 128, kColumns = 256;
constexpr double kCellAngle = 4 * portable::kPi / (kRows * kColumns);

Vec3 direction_in(double row, double column) {
  return direction_at(1 - 2 * row / kRows, column / kColumns);
}

/// How many looks on a side a cell takes, so that no texel is left out by much.
int looks_per_cell(const Background& background) {
  uint32_t widest = 0;
  if (background.picture) widest = background.picture->settings().width;
  for (const auto& face : background.cube) {
    if (face) widest = std::max(widest, 4 * face->settings().width);
  }
  return std::clamp(static_cast<int>((widest + kColumns - 1) / kColumns), 1, 16);
}

/// The mean of what is seen in each cell, rows from +z.
std::vector<double> look_around(const Background& background) {
  const int looks = looks_per_cell(background);
  std::vector<double> seen;
  for (int cell = 0; cell < kRows * kColumns; ++cell) {
    double mean = 0;
    const int row = cell / kColumns, column = cell % kColumns;
    for (int i = 0; i < looks * looks; ++i) {
      const int down = i / looks, right = i % looks;
      const Vec3 d = direction_in(row + (down + 0.5) / looks, column + (right + 0.5) / looks);
      const Color c = background.radiance({}, d, {});
      mean += std::max(0.0, c.r + c.g + c.b) / (looks * looks);
    }
    seen.push_back(mean);
  }
  return seen;
}

/// The number of the step that `u` of the whole falls into; `rest` is how far into it.
size_t choose(std::span<const double> sums, double u, double& rest) {
  const double at = u * sums.back();
  const auto found = std::upper_bound(sums.begin(), sums.end() - 1, at);
  const double below = found == sums.begin() ? 0 : *(found - 1);
  rest = *found > below ? std::clamp((at - below) / (*found - below), 0.0, 1.0) : 0.5;
  return static_cast<size_t>(found - sums.begin());
}

}  // namespace

EnvironmentSampler::EnvironmentSampler(const Background& background) {
  Background plain = background;
  plain.glow = 0;  // it depends on the place
  plain.has_sun_disc = false;
  if (plain.daylight && plain.daylight->has_sun() && !plain.has_cube) {
    daylight_ = plain.daylight;
    rotation_ = plain.rotation;
    const Color sun = daylight_->sun_at_center() * (1 - plain.transparency);
    sun_ = (sun.r + sun.g + sun.b) / (Sky::sun_density() * kCellAngle);
  }
  const std::vector<double> seen = look_around(plain);
  const auto at = [&](int row, int column) {
    const int cell = std::clamp(row, 0, kRows - 1) * kColumns + (column + kColumns) % kColumns;
    return seen[static_cast<size_t>(cell)];
  };
  for (int row = 0; row < kRows; ++row) {
    double sum = 0;
    for (int column = 0; column < kColumns; ++column) {
      // With some of its neighbours' light, for a bright spot may reach over the edge.
      double around = 0;
      for (int i = 0; i < 9; ++i) around += at(row + i / 3 - 1, column + i % 3 - 1) / 9;
      sum += 0.75 * at(row, column) + 0.25 * around;
      cells_.push_back(sum);
    }
    total_ += sum;
    rows_.push_back(total_);
  }
}

EnvironmentSampler::Sample EnvironmentSampler::sample(const Vec2& u) const {
  const double share = sun_share();
  if (u.x >= share) {
    Sample sample =
        sample_cells({std::min((u.x - share) / (1 - share), 0x1.fffffffffffffp-1), u.y});
    if (sample.density > 0) sample.density = density(sample.wi);
    return sample;
  }
  const Vec3 turned = daylight_->sample_sun({u.x / share, u.y});
  const Vec3 wi = rotation_[0] * turned.x + rotation_[1] * turned.y + rotation_[2] * turned.z;
  return {wi, density(wi)};
}

double EnvironmentSampler::density(const Vec3& d) const {
  const double share = sun_share();
  double sum = total_ > 0 ? cell_density(d) * (1 - share) : 0;
  if (share > 0) {
    const Vec3 turned{dot(rotation_[0], d), dot(rotation_[1], d), dot(rotation_[2], d)};
    if (daylight_->is_sun(turned)) sum += share * Sky::sun_density();
  }
  return sum;
}

EnvironmentSampler::Sample EnvironmentSampler::sample_cells(const Vec2& u) const {
  double y, x;
  const size_t row = choose(rows_, u.y, y);
  const std::span<const double> cells(cells_.data() + row * kColumns, kColumns);
  if (!(cells.back() > 0)) return {};
  const size_t column = choose(cells, u.x, x);
  const double cell = cells[column] - (column > 0 ? cells[column - 1] : 0);
  return {direction_in(static_cast<double>(row) + y, static_cast<double>(column) + x),
          cell / (total_ * kCellAngle)};
}

double EnvironmentSampler::cell_density(const Vec3& d) const {
  const auto step = [](double part, int count) {
    return std::clamp(static_cast<int>(part * count), 0, count - 1);
  };
  double turn = portable::atan2(d.y, d.x) / (2 * portable::kPi);
  if (turn < 0) turn += 1;
  const int row = step((1 - d.z) / 2, kRows), column = step(turn, kColumns);
  const double* const cells = cells_.data() + row * kColumns;
  return (cells[column] - (column > 0 ? cells[column - 1] : 0)) / (total_ * kCellAngle);
}

std::shared_ptr<const EnvironmentSampler> make_environment_sampler(const Background& background) {
  const bool has_picture = background.picture != nullptr || background.has_cube ||
                           background.kind == BackgroundKind::sun_and_sky;
  if (!has_picture) return nullptr;
  auto sampler = std::make_shared<EnvironmentSampler>(background);
  if (sampler->is_dark()) return nullptr;
  return sampler;
}

}  // namespace tessera
