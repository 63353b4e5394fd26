#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/accel/bvh_kernels.h"
#include "renderer/accel/ray_row.h"
#include "renderer/integrator/integrator.h"
#include "renderer/math/color.h"
#include "renderer/scene/scene.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// Follows the paths of several samples bounce by bounce, through scenes whose surfaces let nothing
/// through unbent: numbers are drawn, rays traced and, where light is scattered evenly, directions
/// and weights worked out of as many paths as a vector holds. It is the arithmetic of a path by
/// itself line by line, no product fused with a sum, so that the bits are the same. So are the
/// counts but those of traversal and, where some surfaces scatter otherwise or have one side,
/// of numbers, of roulette and of shadow rays left out where a texture is black. Immutable;
/// thread-safe, each thread with its state.
class PathRows {
 public:
  /// Paths at a time.
  static constexpr size_t kMost = RayRow::kMost;

  /// Whether it can: no veils, nothing that absorbs, no fog, and something to hit.
  static bool can_follow(const Scene& scene);
  /// Of a scene that it can follow paths through, by the instructions of the set that BvhKernels of
  /// that name are of. `scene` must outlive it.
  explicit PathRows(const Scene& scene, std::string_view instructions = kernels().name);
  PathRows(const PathRows&) = delete;
  PathRows& operator=(const PathRows&) = delete;
  /// The radiance along each of 1 to kMost camera rays, which begin and end at the same t, into
  /// `found`; `keys` are those of the samples, which tell the rays' cones too. Other numbers are
  /// refused by a check.
  void radiances(std::span<const Ray> rays, std::span<const SampleKey> keys, std::span<Color> found,
                 TraceState& state) const;
  /// The same of a pinhole's rays through raster points.
  void radiances(const Camera::Pinhole& camera, std::span<const Sampler::RasterSample> rasters,
                 std::span<const SampleKey> keys, std::span<Color> found, TraceState& state) const;

  /// How the surface at a hit of an instance is worked out.
  enum class Form : uint8_t { rectangle, mesh, other };
  /// What is seen of a material without textures and vertex colours.
  struct Side {
    Color diffuse;
    bool shines = false;
  };
  struct Placed {
    Form form = Form::other;
    const Instance* instance = nullptr;
    const Rectangle* rectangle = nullptr;  ///< as it stands in the world
    Vec3 normal;                           ///< of the rectangle's front
    const TriangleMesh* mesh = nullptr;
    bool is_even = false;                          ///< all its materials only scatter evenly
    bool has_inputs = false;                       ///< some material is to be looked up
    bool is_uniform = false;                       ///< neither colours nor materials differ on it
    const Side *front = nullptr, *back = nullptr;  ///< null: hits are to be asked one by one
  };
  const Scene& scene() const { return scene_; }
  const Placed& placed(uint32_t instance) const { return placed_[instance]; }

  /// Of one instruction set.
  struct Code {
    void (*follow_rays)(const PathRows&, std::span<const Ray>, std::span<const SampleKey>,
                        std::span<Color>, TraceState&);
    void (*follow_rasters)(const PathRows&, const Camera::Pinhole&,
                           std::span<const Sampler::RasterSample>, std::span<const SampleKey>,
                           std::span<Color>, TraceState&);
  };

 private:
  Placed place(uint32_t number) const;
  void find_sides(uint32_t number, Placed& placed) const;

  const Scene& scene_;
  Code code_;
  std::vector<Side> sides_;     ///< one a material
  std::vector<Placed> placed_;  ///< one an instance
};

}  // namespace tessera
