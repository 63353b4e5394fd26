#include "renderer/shapes/curved_sampler.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/shapes/area_density.h"

namespace tessera {

double CurvedSampler::sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const {
  const CurvedPoint chosen = choose(u);
  sample.point = to_world_.point(chosen.point);
  sample.point_error = rounding_of(sample.point, reach_);
  const Vec3 normal = normalize(static_cast<Vec3>(to_world_.normal(to_normal(chosen.normal))));
  sample.normal = flip_ ? -normal : normal;
  return density(from, sample.point, sample.normal, 0);
}

double CurvedSampler::density(const LitPoint& from, const Point3& there, const Vec3& normal,
                              uint32_t) const {
  return density_by_area(own_area_ * area_growth(to_world_.matrix(), normal), from.at, there,
                         normal);
}

double CurvedSampler::area() const {
  const double scale = portable::pow(std::abs(to_world_.matrix().determinant()), 2.0 / 3);
  return std::max(own_area_ * scale, 1e-300);
}

}  // namespace tessera
