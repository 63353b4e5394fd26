#include "renderer/accel/bvh_kernels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/targets.h"
#include "renderer/shapes/triangle.h"

// This file is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/accel/bvh_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "renderer/accel/box_soa-inl.h"
#include "renderer/accel/instance_soa-inl.h"
#include "renderer/accel/packet-inl.h"
#include "renderer/accel/plane_soa-inl.h"
#include "renderer/accel/rectangle_soa-inl.h"
#include "renderer/accel/test_triangles-inl.h"
#include "renderer/accel/traverse-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

/// The way out where single precision cannot hold a ray or tell a tree's boxes apart; kept apart so
/// that the usual way stays short.
HWY_NOINLINE bool mesh_closest_in_double(const MeshTree& mesh, const TriangleRay& ray,
                                         const RayFrame& frame, Hit& hit,
                                         TraversalCounters& counters) {
  const TriangleTester tester(mesh, ray);
  BoxRay<double> box_ray = make_box_ray<double>(frame);
  return closest_in_tree<true>(mesh.tree, box_ray, box_ray.t_max, counters.node_visits,
                               [&](uint32_t leaf) HWY_ATTR {
                                 if (!tester.closest(leaf, hit, counters.primitive_tests))
                                   return false;
                                 box_ray.t_max = box_ray.limit(hit.t);
                                 return true;
                               });
}

HWY_NOINLINE bool mesh_any_in_double(const MeshTree& mesh, const TriangleRay& ray,
                                     const RayFrame& frame, TraversalCounters& counters) {
  const TriangleTester tester(mesh, ray);
  BoxRay<double> box_ray = make_box_ray<double>(frame);
  return any_in_tree<true>(mesh.tree, box_ray, box_ray.t_max, counters.node_visits,
                           [&](uint32_t leaf)
                               HWY_ATTR { return tester.any(leaf, counters.primitive_tests); });
}

/// How the box test of a ray is set up; `wide`: single precision cannot hold it.
enum class Setup { ready, misses, wide };
HWY_NOINLINE Setup set_up_unusual(const Ray& ray, double t_max, const Bounds3& whole,
                                  const TraversalTree& tree, RayFrame& frame,
                                  BoxRay<float>& box_ray) {
  const Vec3& d = ray.direction;
  if (!is_finite(ray.origin - Point3{}) || std::isnan(d.x) || std::isnan(d.y) || std::isnan(d.z))
    return Setup::misses;
  frame = make_ray_frame(ray, t_max, whole, double{tree.extent}, tree.margin);
  if (frame.misses) return Setup::misses;
  if (!frame.fits_float || tree.usual_extent == 0) return Setup::wide;
  box_ray = make_box_ray<float>(frame);
  return Setup::ready;
}
template <bool kJustMade>
HWY_INLINE Setup set_up(const Ray& ray, double t_max, const Bounds3& whole,
                        const TraversalTree& tree, RayFrame& frame, BoxRay<float>& box_ray) {
  if (make_usual_box_ray<kJustMade>(ray, t_max, tree.usual_extent, box_ray)) [[likely]]
    return Setup::ready;
  return set_up_unusual(ray, t_max, whole, tree, frame, box_ray);
}

/// Calls `test(tester, leaf)` for every leaf on the ray's line, before the ray and behind its hits
/// too, until it returns true: for rays whose t may be told far from the piece that they cross.
template <typename Test>
HWY_NOINLINE bool test_line(const MeshTree& mesh, const Ray& ray, uint64_t& visits, Test test) {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  const TriangleTester tester(mesh, prepared);
  const auto leaf = [&](uint32_t reference) HWY_ATTR { return test(tester, reference); };
  Ray line = ray;
  line.t_min = 0;
  line.t_max = Bounds3::kInfinity;
  BoxRay<float> box_ray;
  if (make_usual_box_ray(line, line.t_max, mesh.tree.usual_extent, box_ray))
    return any_in_tree<true>(mesh.tree, box_ray, box_ray.t_max, visits, leaf);
  line.t_min = -Bounds3::kInfinity;
  const RayFrame frame =
      make_ray_frame(line, line.t_max, mesh.bounds, double{mesh.tree.extent}, mesh.tree.margin);
  if (frame.misses) return false;
  BoxRay<double> wide_ray = make_box_ray<double>(frame);
  return any_in_tree<true>(mesh.tree, wide_ray, wide_ray.t_max, visits, leaf);
}

bool mesh_closest(const MeshTree& mesh, const Ray& ray, Hit& hit, TraversalCounters& counters) {
  // What a few triangles need is less than a box test's preparation.
  if (mesh.tree.root & TraversalTree::kLeaf) [[unlikely]] {
    const TriangleRay prepared(ray);
    return prepared.valid() &&
           TriangleTester(mesh, prepared).closest(mesh.tree.root, hit, counters.primitive_tests);
  }
  if (mesh.cut_planes.count > 0 && mesh.cut_planes.must_visit_all(ray, mesh.tree.extent))
      [[unlikely]] {
    bool found = false;
    test_line(mesh, ray, counters.node_visits,
              [&](const TriangleTester& tester, uint32_t leaf) HWY_ATTR {
                found |= tester.closest(leaf, hit, counters.primitive_tests);
                return false;
              });
    return found;
  }
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup =
      set_up<false>(ray, std::min(ray.t_max, hit.t), mesh.bounds, mesh.tree, frame, box_ray);
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
      [[unlikely]] {
    return test_line(mesh, ray, counters.node_visits,
                     [&](const TriangleTester& tester, uint32_t leaf)
                         HWY_ATTR { return tester.any(leaf, counters.primitive_tests); });
  }
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup = set_up<false>(ray, ray.t_max, mesh.bounds, mesh.tree, frame, box_ray);
  if (setup == Setup::misses) return false;
  const TriangleRay prepared(ray);
  if (setup == Setup::wide) [[unlikely]]
    return prepared.valid() && mesh_any_in_double(mesh, prepared, frame, counters);
  const TriangleTester tester(mesh, prepared);
  TraversalCounters done;
  const bool found = any_in_tree<true>(
      mesh.tree, box_ray, box_ray.t_max,
      done.node_visits, [&](uint32_t leaf) HWY_ATTR __attribute__((always_inline)) {
        return tester.any(leaf, done.primitive_tests);
      });
  counters.node_visits += done.node_visits;
  counters.primitive_tests += done.primitive_tests;
  return found;
}

bool leaf_closest(const MeshTree& mesh, uint32_t leaf, const TriangleRay& ray, Hit& hit,
                  TraversalCounters& counters) {
  return TriangleTester(mesh, ray).closest(leaf, hit, counters.primitive_tests);
}

bool leaf_any(const MeshTree& mesh, uint32_t leaf, const TriangleRay& ray,
              TraversalCounters& counters) {
  return TriangleTester(mesh, ray).any(leaf, counters.primitive_tests);
}

void leaf_all(const MeshTree& mesh, uint32_t leaf, const TriangleRay& ray, std::vector<Hit>& hits,
              TraversalCounters& counters) {
  TriangleTester(mesh, ray).all(leaf, hits, counters.primitive_tests);
}

void mesh_all(const MeshTree& mesh, const Ray& ray, std::vector<Hit>& hits,
              TraversalCounters& counters) {
  test_line(mesh, ray, counters.node_visits,
            [&](const TriangleTester& tester, uint32_t leaf) HWY_ATTR {
              tester.all(leaf, hits, counters.primitive_tests);
              return false;
            });
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
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup =
      set_up<true>(ray, std::min(ray.t_max, hit.t), scene.tree_bounds, scene.tree, frame, box_ray);
  if (setup != Setup::ready && !can_hit(ray)) return false;
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
  if (setup == Setup::misses) return found;
  if (setup == Setup::wide) [[unlikely]] {
    BoxRay<double> wide_ray = make_box_ray<double>(frame);
    wide_ray.t_max = wide_ray.limit(std::min(ray.t_max, hit.t));
    const bool in_tree = closest_in_tree<false>(scene.tree, wide_ray, wide_ray.t_max,
                                                counters.node_visits, [&](uint32_t leaf) HWY_ATTR {
                                                  if (!test(leaf)) return false;
                                                  wide_ray.t_max = wide_ray.limit(hit.t);
                                                  return true;
                                                });
    return found || in_tree;
  }
  if (found) box_ray.t_max = box_ray.limit(hit.t);
  const bool in_tree = closest_in_tree<false>(scene.tree, box_ray, box_ray.t_max,
                                              counters.node_visits, [&](uint32_t leaf) HWY_ATTR {
                                                if (!test(leaf)) return false;
                                                box_ray.t_max = box_ray.limit(hit.t);
                                                return true;
                                              });
  return found || in_tree;
}

bool instance_any(const InstanceTree& scene, const Ray& ray, uint32_t& first,
                  TraversalCounters& counters) {
  if (first != kNoInstance) {
    if (any_hit_of(scene.instances[first], ray, counters)) return true;
    first = kNoInstance;
  }
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup = set_up<true>(ray, ray.t_max, scene.tree_bounds, scene.tree, frame, box_ray);
  if (setup != Setup::ready && !can_hit(ray)) return false;
  const auto is_hit = [&](uint32_t number) HWY_ATTR {
    if (!any_hit_of(scene.instances[number], ray, counters)) return false;
    first = number;
    return true;
  };
  for (const uint32_t i : scene.endless)
    if (is_hit(i)) return true;
  Mailbox mailbox;
  const auto test = [&](uint32_t leaf) HWY_ATTR {
    const NodeReference run{leaf};
    for (uint32_t i = 0; i < run.blocks(); ++i) {
      const uint32_t number = scene.slots[run.first_block() + i];
      if (!mailbox.tested(number) && is_hit(number)) return true;
    }
    return false;
  };
  if (setup == Setup::misses) return false;
  if (setup == Setup::wide) [[unlikely]] {
    BoxRay<double> wide_ray = make_box_ray<double>(frame);
    return any_in_tree<false>(scene.tree, wide_ray, wide_ray.t_max, counters.node_visits, test);
  }
  return any_in_tree<false>(scene.tree, box_ray, box_ray.t_max, counters.node_visits, test);
}

void instance_all(const InstanceTree& scene, const Ray& ray, std::vector<Hit>& hits,
                  TraversalCounters& counters) {
  if (!can_hit(ray)) return;
  for (const uint32_t i : scene.endless) all_hits_of(scene.instances[i], i, ray, hits, counters);
  Mailbox mailbox;
  const auto collect = [&](uint32_t leaf) HWY_ATTR {
    const NodeReference run{leaf};
    for (uint32_t i = 0; i < run.blocks(); ++i) {
      const uint32_t number = scene.slots[run.first_block() + i];
      if (!mailbox.tested(number))
        all_hits_of(scene.instances[number], number, ray, hits, counters);
    }
    return false;
  };
  RayFrame frame;
  BoxRay<float> box_ray;
  const Setup setup = set_up<true>(ray, ray.t_max, scene.tree_bounds, scene.tree, frame, box_ray);
  if (setup == Setup::misses) return;
  if (setup == Setup::wide) [[unlikely]] {
    BoxRay<double> wide_ray = make_box_ray<double>(frame);
    any_in_tree<false>(scene.tree, wide_ray, wide_ray.t_max, counters.node_visits, collect);
    return;
  }
  any_in_tree<false>(scene.tree, box_ray, box_ray.t_max, counters.node_visits, collect);
}

BvhKernels kernels_of_target() {
  return {mesh_closest,
          mesh_any,
          mesh_all,
          mesh_closest_packet,
          mesh_any_packet,
          leaf_closest,
          leaf_any,
          leaf_all,
          instance_closest,
          instance_any,
          instance_all,
          instance_closest_packet,
          instance_any_packet,
          boxes_entered,
          rectangles_met,
          planes_met,
          intersect_batch,
          hwy::TargetName(HWY_TARGET)};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {
namespace {

std::vector<BvhKernels> kernels_of_machine() {
  std::vector<BvhKernels> list;
  for (const auto& kernels : codes_of_machine(TESSERA_EACH_TARGET(kernels_of_target)))
    list.push_back(kernels());
  return list;
}

BvhKernels chosen_kernels() {
  const char* const wanted = std::getenv("TESSERA_SIMD");
  if (!wanted) return all_kernels().front();
  std::vector<std::string> names;
  for (const BvhKernels& code : all_kernels()) {
    if (std::string_view(code.name) == wanted) return code;
    names.emplace_back(code.name);
  }
  throw usage_error(fmt::format("TESSERA_SIMD: '{}'; expected one of {}{}", wanted,
                                fmt::join(names, ", "), suggestion(wanted, names)));
}

}  // namespace

std::span<const BvhKernels> all_kernels() {
  static const std::vector<BvhKernels> all = kernels_of_machine();
  return all;
}

const BvhKernels& common_kernels() {
  // The best that round each product, as a machine does that has no other.
  const auto all = all_kernels();
  const auto found = std::ranges::find(all, std::string_view("SSE4"), &BvhKernels::name);
  return found == all.end() ? all.back() : *found;
}

const BvhKernels& kernels() {
  static const BvhKernels chosen = chosen_kernels();
  return chosen;
}

}  // namespace tessera
#endif  // HWY_ONCE
