#pragma once

#include <fmt/format.h>

#include <atomic>

#include "base/error.h"
#include "base/parallel.h"
#include "renderer/query/ray_arrays.h"

namespace tessera {

/// How many rays one thread takes at a time. What is made of a ray depends on no other.
inline constexpr size_t kRaysOfChunk = 1024;

/// Calls work(begin, end) for all chunks of `count` rays; false where it was cancelled.
template <typename Work>
bool for_each_chunk(size_t count, const QueryControl& control, const Work& work) {
  const auto is_cancelled = [&] {
    return control.cancelled && control.cancelled->load(std::memory_order_relaxed);
  };
  for_each_piece_parallel(count, kRaysOfChunk, control.threads, [&](size_t begin, size_t end) {
    if (!is_cancelled()) work(begin, end);
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
/// Ray `i`, copied to where the batch keeps it; a usage error where it begins before its origin.
[[gnu::always_inline]] inline Ray checked_ray(const RayBatch& rays, size_t i) {
  const Ray ray = rays[i];
  if (ray.t_min < 0) [[unlikely]]
    refuse_t_min(i, ray.t_min);
  if (rays.kept_origins) keep(ray.origin - Point3{}, rays.kept_origins, i);
  if (rays.kept_directions) keep(ray.direction, rays.kept_directions, i);
  return ray;
}

}  // namespace tessera
