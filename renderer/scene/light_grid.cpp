#include "renderer/scene/light_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tessera {

namespace {

/// Below this many that end, asking each is as fast.
constexpr size_t kFewLights = 4;
/// References in all cells, at most.
constexpr size_t kMostReferences = size_t{1} << 22;
constexpr int kMostCells = 32;
/// Of all lengths: far above the rounding of a distance.
constexpr double kMargin = 1e-9;

bool ends(const Light& light) {
  return light.is_placed() && std::isfinite(light.radius / light.frame_scale) &&
         (light.ambient_attenuated || is_black(light.ambient));
}

double reach_of(const Light& light) {
  const double far = std::max(
      {std::abs(light.position.x), std::abs(light.position.y), std::abs(light.position.z)});
  const double radius = light.radius / light.frame_scale;
  return radius + kMargin * (radius + far);
}

/// Cells along an axis: about eight for each light that ends; each may list `all`.
int side_for(size_t ending, size_t all) {
  const size_t cells = std::min(8 * ending, kMostReferences / all);
  return std::clamp(static_cast<int>(std::cbrt(static_cast<double>(cells))), 1, kMostCells);
}

}  // namespace

LightGrid::LightGrid(std::span<const Light> lights, std::vector<uint32_t> indices)
    : all_(std::move(indices)) {
  for (const uint32_t i : all_) {
    if (!ends(lights[i])) {
      endless_.push_back(i);
      continue;
    }
    const Vec3 reach = Vec3{1, 1, 1} * reach_of(lights[i]);
    box_.extend(Bounds3{lights[i].position - reach, lights[i].position + reach});
  }
  const size_t ending = all_.size() - endless_.size();
  if (ending < kFewLights || !is_finite(box_.max - box_.min)) return;
  side_ = side_for(ending, all_.size());
  fill(lights);
}

template <typename Visit>
void LightGrid::for_each_cell(const Light& light, const Visit& visit) const {
  const Vec3 cell = (box_.max - box_.min) / side_;
  const double reach = ends(light) ? reach_of(light) : Bounds3::kInfinity;
  std::array<int, 3> first{}, last{};
  for (int a = 0; a < 3; ++a) {
    // Another one on either side, for rounding. Not a number where the box is flat.
    const auto nearest = [&](double at) {
      return at >= 0 ? static_cast<int>(std::min(at, side_ - 1.0)) : 0;
    };
    const double middle = light.position[a] - box_.min[a];
    first[a] = nearest((middle - reach) / cell[a] - 1);
    last[a] = nearest((middle + reach) / cell[a] + 1);
  }
  for (int z = first[2]; z <= last[2]; ++z) {
    for (int y = first[1]; y <= last[1]; ++y) {
      for (int x = first[0]; x <= last[0]; ++x) {
        const Point3 low = box_.min + Vec3{cell.x * x, cell.y * y, cell.z * z};
        double squares = 0;  // of the distance from the cell
        for (int a = 0; a < 3; ++a) {
          const double below = low[a] - light.position[a];
          const double above = light.position[a] - (low[a] + cell[a]);
          const double apart = std::max({below, above, 0.0}) - kMargin * cell[a];
          squares += apart > 0 ? apart * apart : 0;
        }
        const int number = (z * side_ + y) * side_ + x;
        if (squares <= reach * reach) visit(static_cast<size_t>(number));
      }
    }
  }
}

void LightGrid::fill(std::span<const Light> lights) {
  const int cells = side_ * side_ * side_;
  first_.assign(static_cast<size_t>(cells) + 1, 0);
  for (const uint32_t i : all_)
    for_each_cell(lights[i], [&](size_t number) { ++first_[number + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  lists_.resize(first_.back());
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  for (const uint32_t i : all_)
    for_each_cell(lights[i], [&](size_t number) { lists_[next[number]++] = i; });
}

std::span<const uint32_t> LightGrid::at_cell(const Point3& p) const {
  size_t number = 0;
  for (int a = 2; a >= 0; --a) {
    const double at = (p[a] - box_.min[a]) / (box_.max[a] - box_.min[a]);
    if (at < 0 || at > 1) return endless_;
    if (!(at >= 0)) return all_;  // not a number
    number = number * static_cast<size_t>(side_) +
             static_cast<size_t>(std::min(static_cast<int>(at * side_), side_ - 1));
  }
  return std::span(lists_).subspan(first_[number], first_[number + 1] - first_[number]);
}

}  // namespace tessera
