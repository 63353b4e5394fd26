#include "renderer/accel/embree_mesh.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>

#include "renderer/accel/box_ray.h"
#include "renderer/accel/tree_boxes.h"
#include "renderer/shapes/triangle.h"

namespace tessera {
namespace {

constexpr uint32_t kUnitsOfBlock = sizeof(TriangleBlock) / sizeof(TreeUnit);

/// What Embree calls back with: our test of the four triangles of a box.
struct Search {
  const MeshTree& blocks;
  const TriangleRay& ray;
  const RayFrame& frame;
  Hit& hit;
  TraversalCounters& counters;
  const BvhKernels& code = kernels();
  bool found = false;
  std::vector<Hit>* all_found = nullptr;

  static float closest(void* context, uint32_t box, float t_max) {
    auto& s = *static_cast<Search*>(context);
    if (!s.code.leaf_closest(s.blocks, kUnitsOfBlock * box, s.ray, s.hit, s.counters)) return t_max;
    s.found = true;
    const double limit = (s.hit.t - s.frame.t_shift) + s.hit.t * BoxRay<float>::kMargin;
    return std::min(t_max, static_cast<float>(limit));
  }
  static float any(void* context, uint32_t box, float t_max) {
    auto& s = *static_cast<Search*>(context);
    s.found = s.code.leaf_any(s.blocks, kUnitsOfBlock * box, s.ray, s.counters);
    return s.found ? -std::numeric_limits<float>::infinity() : t_max;
  }
  static float all(void* context, uint32_t box, float t_max) {
    auto& s = *static_cast<Search*>(context);
    s.code.leaf_all(s.blocks, kUnitsOfBlock * box, s.ray, *s.all_found, s.counters);
    return t_max;
  }
};

/// Twice the margin of our own box test: Embree rounds more, and approximates reciprocals.
constexpr double kGrowth = 2 * BoxRay<float>::kMargin;

/// False where Embree cannot hold the ray.
bool to_embree(const Ray& ray, const RayFrame& f, double extent, EmbreeBoxRay& out) {
  if (!f.fits_float || f.margin > 4 * extent * BoxRay<float>::kMargin) return false;
  for (int a = 0; a < 3; ++a) {
    out.origin[a] = static_cast<float>(f.origin[a]);
    out.direction[a] = static_cast<float>(ray.direction[a]);
  }
  const BoxRay<float> b = make_box_ray<float>(f);
  out.t_min = b.t_min;
  out.t_max = b.t_max;
  return out.t_max >= out.t_min;  // false for what is not a number
}

}  // namespace

std::unique_ptr<const EmbreeMesh> EmbreeMesh::make(std::shared_ptr<const TriangleMesh> mesh,
                                                   int threads) {
  const auto start = std::chrono::steady_clock::now();
  std::unique_ptr<EmbreeMesh> made(new EmbreeMesh(mesh));
  WideTree groups = build_wide_tree(triangle_boxes(*mesh, threads), 4, threads);
  made->extent_ = groups.extent;
  // A ray's origin is at most four extents away, or moved to the whole.
  const float growth = static_cast<float>(4 * kGrowth * double{groups.extent});
  made->boxes_.resize(groups.slots.size() / 4);
  made->blocks_.tree.units = AlignedArray<TreeUnit>(made->boxes_.size() * kUnitsOfBlock);
  for (size_t b = 0; b < made->boxes_.size(); ++b) {
    Bounds3 box;
    const uint32_t* slots = groups.slots.data() + 4 * b;
    for (size_t i = 0; i < 4; ++i)
      if (slots[i] != WideTree::kEmptySlot)
        for (const Point3& p : mesh->corners(slots[i])) box.extend(p);
    const TriangleBlock block = make_block(*mesh, slots, true);
    std::memcpy(static_cast<void*>(made->blocks_.tree.units.data() + b * kUnitsOfBlock), &block,
                sizeof block);
    for (int a = 0; a < 3; ++a) {
      made->boxes_[b][static_cast<size_t>(a)] = static_cast<float>(box.min[a]) - growth;
      made->boxes_[b][static_cast<size_t>(a) + 3] = static_cast<float>(box.max[a]) + growth;
    }
  }
  made->embree_ = make_embree_boxes(made->boxes_, threads);
  if (!made->embree_) return nullptr;
  made->statistics_ = {.primitives = mesh->triangles.size(),
                       .leaves = made->boxes_.size(),
                       .references = mesh->triangles.size(),
                       .bytes = made->embree_->bytes() + made->blocks_.tree.units.bytes() +
                                made->boxes_.size() * sizeof(made->boxes_[0])};
  made->statistics_.build_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return made;
}

bool EmbreeMesh::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  const RayFrame frame = make_ray_frame(ray, std::min(ray.t_max, hit.t), bounds(), double{extent_});
  if (frame.misses) return false;
  EmbreeBoxRay to;
  if (!to_embree(ray, frame, extent_, to)) return scan_.closest_hit(ray, hit, counters);
  Search search{blocks_, prepared, frame, hit, counters};
  embree_->visit(to, Search::closest, &search);
  return search.found;
}

bool EmbreeMesh::any_hit(const Ray& ray, TraversalCounters& counters) const {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return false;
  const RayFrame frame = make_ray_frame(ray, ray.t_max, bounds(), double{extent_});
  if (frame.misses) return false;
  EmbreeBoxRay to;
  if (!to_embree(ray, frame, extent_, to)) return scan_.any_hit(ray, counters);
  Hit unused;
  Search search{blocks_, prepared, frame, unused, counters};
  embree_->visit_any(to, Search::any, &search);
  return search.found;
}

void EmbreeMesh::all_hits(const Ray& ray, std::vector<Hit>& hits,
                          TraversalCounters& counters) const {
  const TriangleRay prepared(ray);
  if (!prepared.valid()) return;
  const RayFrame frame = make_ray_frame(ray, ray.t_max, bounds(), double{extent_});
  if (frame.misses) return;
  EmbreeBoxRay to;
  if (!to_embree(ray, frame, extent_, to)) return scan_.all_hits(ray, hits, counters);
  Hit unused;
  Search search{blocks_, prepared, frame, unused, counters};
  search.all_found = &hits;
  embree_->visit_any(to, Search::all, &search);
}

}  // namespace tessera
