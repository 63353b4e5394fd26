#pragma once

#include <memory>
#include <string_view>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/integrator/batch_tracer.h"

namespace tessera {

/// Follows one segment of a path to its end, with all that branches off it: for what is rare in a
/// batch. Returns `sum` and what it found. Thread-safe, each thread with its state.
class SegmentTracer {
 public:
  virtual ~SegmentTracer() = default;
  virtual Color trace_to_end(const Color& sum, const PathSegment& segment,
                             TraceState& state) const = 0;
};

/// Whether rays through the scene can be followed in batches from mirror to mirror: it has simple
/// features, and surfaces.
bool can_batch_whitted(const Scene& scene);
/// Batches of rays through such a scene, by the instructions of the set that BvhKernels of that
/// name are of. The counts are those of single rays but those that integrator.h names. `scene` and
/// `alone` must outlive it.
std::unique_ptr<const BatchTracer> make_whitted_batches(
    const Scene& scene, const SegmentTracer& alone, std::string_view instructions = kernels().name);

}  // namespace tessera
