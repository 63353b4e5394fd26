#pragma once

#include <string>
#include <vector>

#include "renderer/accel/instance.h"
#include "tests/numerics/accelerators.h"

namespace tessera::numerics {

inline Transform random_affine(Random& random, double exponent) {
  const double scale = std::pow(10, random.uniform(-exponent, exponent));
  Affine a;
  do {
    for (auto& row : a.m)
      for (int c = 0; c < 3; ++c) row[static_cast<size_t>(c)] = random.uniform(-1, 1);
  } while (std::abs(a.determinant()) < 0.05);
  for (auto& row : a.m) {
    for (double& entry : row) entry *= scale;
    row[3] = random.uniform(-1, 1) * scale * std::pow(10, random.uniform(-1, 3));
  }
  return Transform(a);
}

struct Spawned {
  int64_t rays = 0, self_hits = 0;
  std::string first;
};

/// Hits the instance with `ray`, then leaves the hit on either side (or, for a solid, outward) and
/// counts rays that meet it again.
inline void leave(const std::vector<Instance>& scene, const Ray& ray, bool solid, Random& random,
                  Spawned& count) {
  Hit hit;
  TraversalCounters counters;
  if (!closest_hit_of(scene[0], 0, ray, hit, counters)) return;
  const SurfaceInteraction s = surface_at(scene, ray, hit);
  for (int i = 0; i < 4; ++i) {
    Vec3 d = random.direction();
    // Grazing directions are the dangerous ones.
    const Vec3 n = static_cast<Vec3>(s.geometric_normal);
    if (i >= 2) d = d - n * (dot(n, d) * (1 - std::pow(10, random.uniform(-12, 0))));
    if (solid && dot(d, n) < 0) d = -d;
    // In the instance's frame, what lies in the surface to rounding may point to its other side.
    if (std::abs(dot(d, n)) < 0x1p-46) continue;
    const Ray spawned = spawn_ray(s, d);
    Hit again;
    ++count.rays;
    if (!closest_hit_of(scene[0], 0, spawned, again, counters) &&
        !any_hit_of(scene[0], spawned, counters))
      continue;
    if (count.self_hits++ == 0) count.first = describe(spawned);
  }
}

}  // namespace tessera::numerics
