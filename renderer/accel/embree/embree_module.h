#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace tessera {

/// A ray and its answer in single precision, as Embree takes it.
struct EmbreeRay {
  float origin[3], direction[3];
  float t_max;
  // Filled by trace: the hit, or t_max itself and an invalid primitive.
  float t;
  uint32_t primitive;
};

/// One mesh in Embree's default (medium quality, not robust) BVH. Thread-safe after construction.
class EmbreeScene {
 public:
  static constexpr uint32_t kNothing = 0xffffffffu;

  virtual ~EmbreeScene() = default;
  /// rtcIntersect1 for each ray.
  virtual void closest_hits(std::span<EmbreeRay> rays) const = 0;
  /// rtcIntersect8 for eight at a time, as coherent rays.
  virtual void closest_hits_by_eights(std::span<EmbreeRay> rays) const = 0;
  /// rtcOccluded1 for each: primitive is 0 where anything was hit, else kNothing.
  virtual void any_hits(std::span<EmbreeRay> rays) const = 0;
  virtual double build_seconds() const = 0;
  virtual size_t bytes() const = 0;
};

/// A ray through boxes, in single precision; t_min is not negative.
struct EmbreeBoxRay {
  float origin[3], direction[3];
  float t_min, t_max;
};

/// Boxes in Embree's BVH (user geometry): it proposes, others decide. Thread-safe after
/// construction.
class EmbreeBoxes {
 public:
  /// Tests what a box holds and gives the t_max to go on with, never more than before; below 0 ends
  /// the search.
  using Test = float (*)(void* context, uint32_t box, float t_max);

  virtual ~EmbreeBoxes() = default;
  /// Calls `test` for every box that the ray may enter before t_max, roughly the nearest first; a
  /// box may come twice.
  virtual void visit(const EmbreeBoxRay& ray, Test test, void* context) const = 0;
  /// The same in no order.
  virtual void visit_any(const EmbreeBoxRay& ray, Test test, void* context) const = 0;
  virtual size_t bytes() const = 0;
};

/// As make_embree_scene, of `boxes`: min xyz, max xyz, each finite. They must outlive the result.
std::unique_ptr<EmbreeBoxes> make_embree_boxes(std::span<const std::array<float, 6>> boxes,
                                               int threads);

/// Loads the module beside the executable on first use. Null where it was not built or cannot be
/// loaded. `positions` are xyz, `triangles` three indices each; `threads` builds.
std::unique_ptr<EmbreeScene> make_embree_scene(std::span<const float> positions,
                                               std::span<const uint32_t> triangles, int threads);

}  // namespace tessera
