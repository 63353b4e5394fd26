#include "renderer/integrator/whitted_batches.h"

#include "base/targets.h"
#include "renderer/integrator/whitted_surfaces.h"

// This file is compiled once for each instruction set, as bvh_kernels.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/integrator/whitted_batches.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/integrator/wavefront-inl.h"
#include "renderer/integrator/whitted_wavefront-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

std::unique_ptr<const BatchTracer> whitted_batches(const Scene& scene) {
  return std::make_unique<BatchTracerOf<WhittedWavefront>>(scene);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

std::unique_ptr<const BatchTracer> make_whitted_batches(const Scene& scene,
                                                        std::string_view instructions) {
  return code_of_target(TESSERA_EACH_TARGET(whitted_batches), instructions)(scene);
}

}  // namespace tessera
#endif  // HWY_ONCE
