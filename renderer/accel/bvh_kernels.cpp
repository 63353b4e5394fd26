#include "renderer/accel/bvh_kernels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

#include "base/error.h"
#include "renderer/shapes/triangle.h"

// This file is compiled once for each instruction set. The sets named here add nothing we use.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/accel/bvh_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/accel/packet-inl.h"
#include "renderer/accel/test_triangles-inl.h"
#include "renderer/accel/traverse-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// The way out for rays that single precision cannot hold; kept apart so that the usual way stays
/// short.
HWY_NOINLINE bool mesh_closest_in_double(const MeshTree& mesh, const TriangleRay& ray,
                                         const RayFrame& frame, Hit& hit,
                                         TraversalCounters& counters) {
  const TriangleTester tester(mesh, ray);
  bool found = false;
  visit_in_double(mesh.tree, make_box_ray<double>(frame), counters.node_visits,
                  [&](uint32_t leaf) HWY_ATTR {
                    found |= tester.closest(leaf, hit, counters.primitive_tests);
                    return false;
                  });
  return found;
}

HWY_NOINLINE bool mesh_any_in_double(const MeshTree& mesh, const TriangleRay& ray,
                                     const RayFrame& frame, TraversalCounters& counters) {
  const TriangleTester tester(mesh, ray);
  bool found = false;
  visit_in_double(mesh.tree, make_box_ray<double>(frame), counters.node_visits,
                  [&](uint32_t leaf)
                      HWY_ATTR { return found = tester.any(leaf, counters.primitive_tests); });
  return found;
}

/// How the box test of a ray is set up; `wide`: single precision cannot hold it.
enum class Setup { ready, misses, wide };
HWY_NOINLINE Setup set_up_unusual(const Ray& ray, double t_max, const Bounds3& whole, float extent,
                                  RayFrame& frame, BoxRay<float>& box_ray) {
  const Vec3& d = ray.direction;
  if (!is_finite(ray.origin - Point3{}) || std::isnan(d.x) || std::isnan(d.y) || std::isnan(d.z))
    return Setup::misses;
  frame = make_ray_frame(ray, t_max, whole, double{extent});
  if (frame.misses) return Setup::misses;
  if (!frame.fits_float) return Setup::wide;
  box_ray = make_box_ray<float>(frame);
  return Setup::ready;
}
HWY_INLINE Setup set_up(const Ray& ray, double t_max, const Bounds3& whole, float extent,
                        RayFrame& frame, BoxRay<float>& box_ray) {
  if (make_usual_box_ray(ray, t_max, extent, box_ray)) [[likely]]
    return Setup::ready;
  return set_up_unusual(ray, t_max, whole, extent, frame, box_ray);
}

/// Calls `leaf` for every leaf on the ray's line, before the ray and behind its hits too, until it
/// returns true.
template <typename Leaf>
HWY_INLINE void visit_line(const MeshTree& mesh, Ray ray, uint64_t& visits, Leaf&& leaf) {
  ray.t_min = 0;
  ray.t_max = Bounds3::kInfinity;
  BoxRay<float> box_ray;
  if (make_usual_box_ray(ray, ray.t_max, mesh.tree.extent, box_ray)) {
    any_in_tree<true>(mesh.tree, box_ray, visits, leaf);
    return;
  }
  ray.t_min = -Bounds3::kInfinity;
  const RayFrame frame = make_ray_frame(ray, ray.t_max, mesh.bounds, mesh.tree.extent);
  if (!frame.misses) visit_in_double(mesh.tree, make_box_ray<double>(frame), visits, leaf);
}

/// For rays whose t may be told far from the piece that they cross.
HWY_NOINLINE bool mesh_closest_on_line(const MeshTree& mesh, const Ray& ray, Hit& hit,
                                       TraversalCounters& counters) {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  const TriangleTester tester(mesh, prepared);
  bool found = false;
  visit_line(mesh, ray, counters.node_visits, [&](uint32_t leaf) HWY_ATTR {
    found |= tester.closest(leaf, hit, counters.primitive_tests);
    return false;
  });
  return found;
}

HWY_NOINLINE bool mesh_any_on_line(const MeshTree& mesh, const Ray& ray,
                                   TraversalCounters& counters) {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  const TriangleTester tester(mesh, prepared);
  bool found = false;
  visit_line(mesh, ray, counters.node_visits, [&](uint32_t leaf) HWY_ATTR {
    return found = tester.any(leaf, counters.primitive_tests);
  });
  return found;
}

bool mesh_closest(const MeshTree& mesh, const Ray& ray, Hit& hit, TraversalCounters& counters) {
  // What a few triangles need is less than a box test's preparation.
  if (mesh.tree.root & TraversalTree::kLeaf) [[unlikely]] {
    const TriangleRay prepared(ray);
    return prepared.valid() &&
           TriangleTester(mesh, prepared).closest(mesh.tree.root, hit, counters.primitive_tests);
  }
  if (mesh.cut_planes.count > 0 && mesh.cut_planes.must_visit_all(ray, mesh.tree.extent))
      [[unlikely]]
    return mesh_closest_on_line(mesh, ray, hit, counters);
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup =
      set_up(ray, std::min(ray.t_max, hit.t), mesh.bounds, mesh.tree.extent, frame, box_ray);
  if (setup == Setup::misses) return false;
  const TriangleRay prepared(ray);
  if (setup == Setup::wide) [[unlikely]]
    return prepared.valid() && mesh_closest_in_double(mesh, prepared, frame, hit, counters);
  const TriangleTester tester(mesh, prepared);
  TraversalCounters done;
  const bool found = closest_in_tree<true>(
      mesh.tree, box_ray, box_ray.t_max,
      done.node_visits, [&](uint32_t leaf) HWY_ATTR __attribute__((always_inline)) {
        if (!tester.closest(leaf, hit, done.primitive_tests)) return false;
        box_ray.t_max = box_ray.limit(hit.t);
        return true;
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return found;
}

bool mesh_any(const MeshTree& mesh, const Ray& ray, TraversalCounters& counters) {
  if (mesh.tree.root & TraversalTree::kLeaf) [[unlikely]] {
    const TriangleRay prepared(ray);
    return prepared.valid() &&
           TriangleTester(mesh, prepared).any(mesh.tree.root, counters.primitive_tests);
  }
  if (mesh.cut_planes.count > 0 && mesh.cut_planes.must_visit_all(ray, mesh.tree.extent))
      [[unlikely]]
    return mesh_any_on_line(mesh, ray, counters);
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup = set_up(ray, ray.t_max, mesh.bounds, mesh.tree.extent, frame, box_ray);
  if (setup == Setup::misses) return false;
  const TriangleRay prepared(ray);
  if (setup == Setup::wide) [[unlikely]]
    return prepared.valid() && mesh_any_in_double(mesh, prepared, frame, counters);
  const TriangleTester tester(mesh, prepared);
  TraversalCounters done;
  const bool found = any_in_tree<true>(
      mesh.tree, box_ray,
      done.node_visits, [&](uint32_t leaf) HWY_ATTR __attribute__((always_inline)) {
        return tester.any(leaf, done.primitive_tests);
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return found;
}

/// Remembers instances that a ray was tested against: an octree holds one in several leaves.
class Mailbox {
 public:
  Mailbox() { std::fill(std::begin(tested_), std::end(tested_), WideTree::kEmptySlot); }
  bool tested(uint32_t number) {
    uint32_t& place = tested_[number % std::size(tested_)];
    if (place == number) return true;
    place = number;
    return false;
  }

 private:
  uint32_t tested_[8];
};

bool instance_closest(const InstanceTree& scene, const Ray& ray, Hit& hit,
                      TraversalCounters& counters) {
  if (!can_hit(ray)) return false;
  bool found = false;
  for (const uint32_t i : scene.endless)
    found |= closest_hit_of(scene.instances[i], i, ray, hit, counters);
  Mailbox mailbox;
  const auto test = [&](uint32_t leaf) HWY_ATTR {
    bool nearer = false;
    const NodeReference run{leaf};
    for (uint32_t i = 0; i < run.blocks(); ++i) {
      const uint32_t number = scene.slots[run.first_block() + i];
      if (mailbox.tested(number)) continue;
      nearer |= closest_hit_of(scene.instances[number], number, ray, hit, counters);
    }
    return nearer;
  };
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup =
      set_up(ray, std::min(ray.t_max, hit.t), scene.tree_bounds, scene.tree.extent, frame, box_ray);
  if (setup == Setup::misses) return found;
  if (setup == Setup::wide) [[unlikely]] {
    visit_in_double(scene.tree, make_box_ray<double>(frame), counters.node_visits,
                    [&](uint32_t leaf) HWY_ATTR {
                      found |= test(leaf);
                      return false;
                    });
    return found;
  }
  const bool in_tree = closest_in_tree<false>(scene.tree, box_ray, box_ray.t_max,
                                              counters.node_visits, [&](uint32_t leaf) HWY_ATTR {
                                                if (!test(leaf)) return false;
                                                box_ray.t_max = box_ray.limit(hit.t);
                                                return true;
                                              });
  return found || in_tree;
}

bool instance_any(const InstanceTree& scene, const Ray& ray, TraversalCounters& counters) {
  if (!can_hit(ray)) return false;
  for (const uint32_t i : scene.endless)
    if (any_hit_of(scene.instances[i], ray, counters)) return true;
  Mailbox mailbox;
  const auto test = [&](uint32_t leaf) HWY_ATTR {
    const NodeReference run{leaf};
    for (uint32_t i = 0; i < run.blocks(); ++i) {
      const uint32_t number = scene.slots[run.first_block() + i];
      if (mailbox.tested(number)) continue;
      if (any_hit_of(scene.instances[number], ray, counters)) return true;
    }
    return false;
  };
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup = set_up(ray, ray.t_max, scene.tree_bounds, scene.tree.extent, frame, box_ray);
  if (setup == Setup::misses) return false;
  if (setup == Setup::wide) [[unlikely]] {
    bool found = false;
    visit_in_double(scene.tree, make_box_ray<double>(frame), counters.node_visits,
                    [&](uint32_t at) HWY_ATTR { return found = test(at); });
    return found;
  }
  return any_in_tree<false>(scene.tree, box_ray, counters.node_visits, test);
}

BvhKernels kernels_of_target() {
  return {mesh_closest,     mesh_any,     mesh_packet,
          instance_closest, instance_any, hwy::TargetName(HWY_TARGET)};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

HWY_EXPORT(kernels_of_target);

namespace {

/// Those of every instruction set that this machine has, after the best of them.
const std::vector<BvhKernels>& best_and_all() {
  static const std::vector<BvhKernels> result = [] {
    // The best is chosen before the choice is tampered with.
    std::vector<BvhKernels> list{HWY_DYNAMIC_DISPATCH(kernels_of_target)()};
    for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      list.push_back(HWY_DYNAMIC_DISPATCH(kernels_of_target)());
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return list;
  }();
  return result;
}

BvhKernels chosen_kernels() {
  const char* const wanted = std::getenv("TESSERA_SIMD");
  if (!wanted) return HWY_DYNAMIC_DISPATCH(kernels_of_target)();
  std::vector<std::string> names;
  for (const BvhKernels& code : all_kernels()) {
    if (std::string_view(code.name) == wanted) return code;
    names.emplace_back(code.name);
  }
  throw usage_error(fmt::format("TESSERA_SIMD: '{}'; expected one of {}{}", wanted,
                                fmt::join(names, ", "), suggestion(wanted, names)));
}

}  // namespace

const BvhKernels& kernels() {
  static const BvhKernels chosen = chosen_kernels();
  return chosen;
}

std::span<const BvhKernels> all_kernels() { return std::span(best_and_all()).subspan(1); }

}  // namespace tessera
#endif  // HWY_ONCE
