#include "renderer/sampler/pixel_filter.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {

namespace {

constexpr int kCells = 512;

double gaussian(double x) {
  constexpr double kDeviations = 3;  // in the radius
  const auto bell = [](double t) { return portable::exp(-0.5 * t * t); };
  return bell(x * kDeviations) - bell(kDeviations);
}

/// Equation 8 of the paper with B = C = 1/3, `x` in radii of two pixels.
double mitchell(double x) {
  const double t = 2 * x;
  if (t < 1) return ((7 * t - 12) * t * t + 16.0 / 3) / 6;
  return (((-7.0 / 3 * t + 12) * t - 20) * t + 32.0 / 3) / 6;
}

double blackman_harris(double x) {
  const double angle = portable::kPi * x;
  return 0.35875 + 0.48829 * portable::cos(angle) + 0.14128 * portable::cos(2 * angle) +
         0.01168 * portable::cos(3 * angle);
}

}  // namespace

double default_radius(PixelFilter filter) {
  switch (filter) {
    case PixelFilter::box:
      return 0.5;
    case PixelFilter::tent:
      return 1;
    case PixelFilter::gaussian:
      return 1.5;
    case PixelFilter::mitchell:
    case PixelFilter::blackman_harris:
      return 2;
  }
  return 0.5;
}

double filter_value(PixelFilter filter, double radius, double x) {
  const double radii = std::abs(x) / radius;
  if (!(radii < 1)) return 0;
  switch (filter) {
    case PixelFilter::box:
      return 1;
    case PixelFilter::tent:
      return 1 - radii;
    case PixelFilter::gaussian:
      return gaussian(radii);
    case PixelFilter::mitchell:
      return mitchell(radii);
    case PixelFilter::blackman_harris:
      return blackman_harris(radii);
  }
  return 0;
}

FilterTable::FilterTable(PixelFilter filter, double radius) {
  double signed_area = 0;
  const auto add = [&](double begin, double end, double near, double far) {
    const bool negative = near + far < 0;
    cells_.push_back({begin, end - begin, std::abs(near), std::abs(far), area_, negative});
    const double area = (end - begin) * (std::abs(near) + std::abs(far)) / 2;
    area_ += area;
    signed_area += negative ? -area : area;
  };
  const auto at = [&](int i) { return radius * i / kCells; };
  for (int i = 0; i < kCells; ++i) {
    const double near = filter_value(filter, radius, at(i));
    const double far = filter_value(filter, radius, at(i + 1));
    if (near * far < 0) {
      const double zero = at(i) + (at(i + 1) - at(i)) * (near / (near - far));
      add(at(i), zero, near, 0);
      add(zero, at(i + 1), 0, far);
    } else {
      add(at(i), at(i + 1), near, far);
    }
  }
  gain_ = area_ / signed_area;
  guide_.resize(kCells);
  for (uint16_t i = 0, cell = 0; i < kCells; ++i) {
    while (cell + 1u < cells_.size() && cells_[cell + 1u].before <= area_ * i / kCells) ++cell;
    guide_[i] = cell;
  }
}

FilterTable::Draw FilterTable::draw(double u) const {
  const double share = std::abs(2 * u - 1);  // of the half that it is in
  const auto slot = static_cast<size_t>(share * kCells);
  size_t i = guide_[std::min<size_t>(slot, kCells - 1)];
  const double area = share * area_;
  while (i + 1 < cells_.size() && cells_[i + 1].before <= area) ++i;
  const Cell& cell = cells_[i];
  // The root of near t + (far - near) t^2 / (2 width) = rest that lies in the cell.
  const double rest = area - cell.before, growth = (cell.far - cell.near) / cell.width;
  const double root = std::sqrt(std::max(0.0, cell.near * cell.near + 2 * growth * rest));
  const double t = rest > 0 ? 2 * rest / (cell.near + root) : 0;
  const double distance = cell.begin + std::min(t, cell.width);
  return {u < 0.5 ? -distance : distance, cell.negative};
}

}  // namespace tessera
