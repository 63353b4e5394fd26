#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/accel/accelerator.h"
#include "renderer/accel/few_instances.h"
#include "renderer/accel/instance.h"
#include "renderer/accel/light_buffer.h"
#include "renderer/shading/light.h"

namespace tessera {

/// What throws shadows.
struct Occluders {
  std::shared_ptr<const Accelerator> opaque;  ///< lets nothing through; null: there is none
  std::shared_ptr<const Accelerator> clear;   ///< may let light through; null: there is none
  bool takes_guesses = false;                 ///< `opaque` does
  std::vector<uint32_t> clear_instances;      ///< Scene::instances by Hit::instance of `clear`

  /// One for each light, where there are a few lights and a few opaque instances, which are `few`.
  std::vector<LightBuffer> buffers;
  const FewInstances* few = nullptr;

  /// For the rays that leave a surface; null where those are to be traced.
  const LightBuffer* buffers_at(const SurfaceInteraction& from) const {
    return few && LightBuffer::has_answers(few->boxes(), from) ? buffers.data() : nullptr;
  }
};

/// How trees of instances are built.
struct TreeSettings {
  AcceleratorKind kind = AcceleratorKind::bvh;
  int threads = 1;
  const BvhKernels* code = &kernels();
};

/// Those of `instances` that `counts` says; `is_clear` is one an instance. `all` is the tree of all
/// instances, used again where all of them are opaque. Buffers are made for `lights`.
Occluders make_occluders(std::span<const Instance> instances, const std::vector<bool>& is_clear,
                         const std::vector<bool>& counts,
                         const std::shared_ptr<const Accelerator>& all,
                         std::span<const Light> lights, const TreeSettings& settings);

/// Whether it is a plane that is seen, and casts shadows, from its front alone, where each of
/// `lights` is: what lies before it is on the lights' side too.
bool shades_nothing(const Instance& instance, std::span<const Light> lights);

}  // namespace tessera
