#include "renderer/accel/embree_mesh.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "renderer/accel/box_ray.h"
#include "renderer/accel/tree_boxes.h"
#include "renderer/shapes/triangle.h"

namespace tessera {
namespace {

/// What Embree calls back with: our test of the four triangles of a box.
struct Search {
  const TriangleMesh& mesh;
  const std::vector<uint32_t>& slots;
  const TriangleRay& ray;
  const RayFrame& frame;
  bool any;
  Hit& hit;
  TraversalCounters& counters;
  bool found = false;

  static float test(void* context, uint32_t box, float t_max) {
    return static_cast<Search*>(context)->test(box, t_max);
  }

 private:
  float test(uint32_t box, float t_max) {
    for (size_t slot = 4 * size_t{box}; slot < 4 * size_t{box} + 4; ++slot) {
      const uint32_t primitive = slots[slot];
      if (primitive == WideTree::kEmptySlot) break;
      ++counters.primitive_tests;
      const auto [a, b, c] = mesh.corners(primitive);
      TriangleHit h;
      if (!intersect_triangle(ray, a, b, c, h)) continue;
      if (any) {
        found = true;
        return -std::numeric_limits<float>::infinity();
      }
      if (h.t > hit.t || (h.t == hit.t && primitive >= hit.primitive)) continue;
      hit = {h.t, h.u, h.v, hit.instance, primitive};
      found = true;
      const double limit = (hit.t - frame.t_shift) + hit.t * BoxRay<float>::kMargin;
      t_max = std::min(t_max, static_cast<float>(limit));
    }
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
  WideTree groups = build_wide_tree(triangle_boxes(*mesh), 4, threads);
  made->slots_ = std::move(groups.slots);
  made->extent_ = groups.extent;
  // A ray's origin is at most four extents away, or moved to the whole.
  const float growth = static_cast<float>(4 * kGrowth * double{groups.extent});
  made->boxes_.resize(made->slots_.size() / 4);
  for (size_t b = 0; b < made->boxes_.size(); ++b) {
    Bounds3 box;
    for (size_t slot = 4 * b; slot < 4 * b + 4; ++slot)
      if (made->slots_[slot] != WideTree::kEmptySlot)
        for (const Point3& p : mesh->corners(made->slots_[slot])) box.extend(p);
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
                       .bytes = made->embree_->bytes() + made->slots_.size() * sizeof(uint32_t) +
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
  Search search{*mesh_, slots_, prepared, frame, false, hit, counters};
  embree_->visit(to, Search::test, &search);
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
  Search search{*mesh_, slots_, prepared, frame, true, unused, counters};
  embree_->visit(to, Search::test, &search);
  return search.found;
}

}  // namespace tessera
