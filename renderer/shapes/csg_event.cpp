#include "renderer/shapes/csg_event.h"

#include "renderer/math/rounding.h"

namespace tessera {
namespace {

/// A bound on the error of the matrices and of the products with them; relative to the sum of the
/// magnitudes that enter.
constexpr double kTransformError = gamma(8);

RayError transformed_error(const Affine& m, const Ray& ray, const RayError& error) {
  RayError local;
  for (int r = 0; r < 3; ++r) {
    const auto& row = m.m[static_cast<size_t>(r)];
    const Vec3 size{std::abs(row[0]), std::abs(row[1]), std::abs(row[2])};
    const Vec3 o = abs(ray.origin - Point3{}), d = abs(ray.direction);
    local.origin[r] = dot(size, error.origin) + kTransformError * (dot(size, o) + std::abs(row[3]));
    local.direction[r] = dot(size, error.direction) + kTransformError * dot(size, d);
  }
  return local;
}

}  // namespace

LocalLine to_solid(const CsgGates::Leaf& leaf, const Ray& ray, const RayError& error) {
  const Affine& m = leaf.csg_from_solid.inverse_matrix();
  return {{m(ray.origin), m(ray.direction)}, transformed_error(m, ray, error)};
}

}  // namespace tessera
