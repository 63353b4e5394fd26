#pragma once

#include <memory>
#include <string_view>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/integrator/row_tracer.h"

namespace tessera {

/// A ray on its way from mirror to mirror.
struct MirrorPath {
  Ray ray;
  Color sum = kBlack;  ///< of what it met so far
  Color throughput = kWhite;
  double path_length = 0;  ///< metres from the camera to the ray's origin
  uint32_t depth = 0;      ///< mirrors so far
};

/// Follows such rays one by one to their ends, for what is rare in a row.
class MirrorPathFollower {
 public:
  virtual ~MirrorPathFollower() = default;
  virtual Color follow_to_end(MirrorPath path, TraceState& state) const = 0;
};

/// Whether rays through the scene can be followed in rows from mirror to mirror: of simple
/// features, with lights near and far, without beams, and no meshes.
bool can_follow_mirrors(const Scene& scene);
/// Rows of rays through such a scene, by the instructions of the set that BvhKernels of that name
/// are of. The counts are those of single rays but those that integrator.h names. `scene` and
/// `alone` must outlive it.
std::unique_ptr<const RowTracer> make_mirror_rows(const Scene& scene,
                                                  const MirrorPathFollower& alone,
                                                  std::string_view instructions = kernels().name);

}  // namespace tessera
