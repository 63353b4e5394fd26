#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "query/ray_arrays.h"

namespace tessera {

/// How many rays one thread takes at a time. What is made of a ray depends on no other.
inline constexpr size_t kRaysOfChunk = 1024;

/// Calls work(begin, end) for all parts of `count` rays, those of a chunk one after the other;
/// false where it was cancelled.
template <typename Work>
bool for_each_chunk(size_t count, const QueryControl& control, const Work& work) {
  const auto is_cancelled = [&] {
    return control.cancelled && control.cancelled->load(std::memory_order_relaxed);
  };
  for_each_piece_parallel(count, kRaysOfChunk, control.threads, [&](size_t begin, size_t end) {
    for (; begin < end && !is_cancelled(); begin += kRaysBetweenLooks)
      work(begin, std::min(begin + kRaysBetweenLooks, end));
  });
  return !is_cancelled();
}

/// Apart from checked_ray(), so that the compiler takes that into loops.
[[noreturn, gnu::noinline, gnu::cold]] inline void refuse_t_min(size_t i, double t_min) {
  throw usage_error(fmt::format("t_min[{}]: {}; expected 0 or more", i, t_min));
}
inline void keep(const Vec3& row, double* rows, size_t i) {
  for (int a = 0; a < 3; ++a) rows[3 * i + static_cast<size_t>(a)] = row[a];
}
/// Whether squares of a direction as long as this may overflow or vanish.
[[gnu::always_inline]] inline bool is_extreme(const Vec3& d) {
  const double longest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  return !(longest > 0x1p-200 && longest < 0x1p200);
}
/// Divides the direction by a power of two, which is exact, so that its longest part is from 1 to
/// 2; the exponent. Each t is the caller's times that power then. A direction of zeros or of parts
/// that are not finite stays.
[[gnu::noinline, gnu::cold]] inline int scale(Ray& ray) {
  Vec3& d = ray.direction;
  const double longest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  if (longest == 0 || !std::isfinite(longest)) return 0;
  const int exponent = std::ilogb(longest);
  for (double* part : {&d.x, &d.y, &d.z}) *part = std::ldexp(*part, -exponent);
  for (double* t : {&ray.t_min, &ray.t_max}) *t = std::ldexp(*t, exponent);
  // Beyond that there is no number for t.
  ray.t_max = std::min(ray.t_max, std::ldexp(std::numeric_limits<double>::max(), exponent));
  return exponent;
}
[[gnu::always_inline]] inline int scale_if_extreme(Ray& ray) {
  return is_extreme(ray.direction) ? scale(ray) : 0;
}
/// Ray `i`, copied to where the batch keeps it; a usage error where it begins before its origin.
[[gnu::always_inline]] inline Ray checked_ray(const RayArrays& rays, size_t i) {
  const Ray ray = rays[i];
  if (ray.t_min < 0) [[unlikely]]
    refuse_t_min(i, ray.t_min);
  if (rays.kept_origins) keep(ray.origin - Point3{}, rays.kept_origins, i);
  if (rays.kept_directions) keep(ray.direction, rays.kept_directions, i);
  return ray;
}

}  // namespace tessera
