// Compiled once for each instruction set: triangle_surface() at many hits of one mesh, a lane each.
#if defined(TESSERA_LANE_TRIANGLE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LANE_TRIANGLE_INL_H
#undef TESSERA_LANE_TRIANGLE_INL_H
#else
#define TESSERA_LANE_TRIANGLE_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "renderer/math/lanes-inl.h"
#include "renderer/math/rounding.h"
#include "renderer/shapes/lane_surface-inl.h"
#include "renderer/shapes/triangle_mesh.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// The vertices of triangles of one mesh.
class TriangleLanes {
 public:
  /// By their numbers, kLanes of them.
  HWY_INLINE TriangleLanes(const TriangleMesh& mesh, const uint32_t* triangles) {
    for (size_t k = 0; k < 3; ++k) {
      alignas(64) int32_t first[kLanes];  // of the parts of its vertex
      for (size_t lane = 0; lane < kLanes; ++lane)
        first[lane] = static_cast<int32_t>(3 * mesh.triangles[triangles[lane]][k]);
      at_[k] = hn::Load(kNarrowIndexTag, first);
    }
  }
  HWY_INLINE Lanes3 of(const std::vector<Float3>& vertices, size_t k) const {
    const auto part = [&](int32_t axis) HWY_ATTR {
      const auto at = at_[k] + hn::Set(kNarrowIndexTag, axis);
      return hn::PromoteTo(kLaneTag, hn::GatherIndex(kNarrowTag, &vertices[0].x, at));
    };
    return {part(0), part(1), part(2)};
  }

 private:
  using NarrowTag = hn::Rebind<float, LaneTag>;
  static constexpr NarrowTag kNarrowTag{};
  static constexpr hn::RebindToSigned<NarrowTag> kNarrowIndexTag{};
  hn::Vec<hn::RebindToSigned<NarrowTag>> at_[3];
};

/// In the mesh's own frame. `bad` gets a bit for each lane that it is not right in.
HWY_INLINE LaneSurface surface_of(const TriangleMesh& mesh, const uint32_t* triangles, Lanes u,
                                  Lanes v, uint32_t& bad) {
  const TriangleLanes lanes(mesh, triangles);
  const Lanes zero = hn::Zero(kLaneTag);
  const Lanes3 weights{broadcast(1) - u - v, u, v};
  Lanes3 corner[3];
  LaneSurface s;
  for (size_t k = 0; k < 3; ++k) corner[k] = lanes.of(mesh.positions, k);
  place_on_triangle(corner, weights, s.point, s.error);
  const Lanes3 n = accurate_cross(corner[1] - corner[0], corner[2] - corner[0]);
  bad = movemask(hn::Not(hn::Gt(max_component(abs(n)), zero)));
  s.front = s.shading = normalize(n);
  if (mesh.normals.empty()) return s;
  const Lanes3 smooth = blend(
      {lanes.of(mesh.normals, 0), lanes.of(mesh.normals, 1), lanes.of(mesh.normals, 2)}, weights);
  s.shading = select(is_normal(smooth), normalize(smooth), s.shading);
  return s;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
