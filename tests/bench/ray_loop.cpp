// The loop that `tessera bench rays` times, as a C function for tests/bench/python_rays.py: it
// traces the caller's rays one by one, without arrays for the results' fields.
#include <cstdint>
#include <cstring>

#include "renderer/accel/make_accelerator.h"

extern "C" [[gnu::visibility("default")]] const void* make_loop(const float* positions,
                                                                uint64_t vertices,
                                                                const uint32_t* triangles,
                                                                uint64_t count) {
  tessera::TriangleMesh mesh;
  mesh.positions.resize(vertices);
  mesh.triangles.resize(count);
  std::memcpy(static_cast<void*>(mesh.positions.data()), positions, vertices * 12);
  std::memcpy(static_cast<void*>(mesh.triangles.data()), triangles, count * 12);
  tessera::drop_degenerate(mesh);
  return tessera::make_mesh_accelerator(
             std::make_shared<const tessera::TriangleMesh>(std::move(mesh)),
             tessera::AcceleratorKind::bvh, 1)
      .release();
}

/// The rays lie ready as the renderer has them, so that the loop is nothing but tracing.
extern "C" [[gnu::visibility("default")]] void* make_rays(const double* origins,
                                                          const double* directions,
                                                          uint64_t count) {
  auto* const rays = new std::vector<tessera::Ray>(count);
  for (uint64_t i = 0; i < count; ++i) {
    const double *o = origins + 3 * i, *d = directions + 3 * i;
    (*rays)[i] = {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}};
  }
  return rays;
}

extern "C" [[gnu::visibility("default")]] void trace_loop(const void* loop, const void* rays,
                                                          double* t, uint32_t* primitive) {
  const auto& accelerator = *static_cast<const tessera::Accelerator*>(loop);
  const auto& all = *static_cast<const std::vector<tessera::Ray>*>(rays);
  tessera::TraversalCounters counters;
  for (size_t i = 0; i < all.size(); ++i) {
    tessera::Hit hit;
    const bool found = accelerator.closest_hit(all[i], hit, counters);
    t[i] = hit.t;
    primitive[i] = found ? hit.primitive : tessera::kNoInstance;
  }
}
