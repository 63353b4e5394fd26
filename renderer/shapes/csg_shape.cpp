#include "renderer/shapes/csg_shape.h"

#include <algorithm>

#include "renderer/math/rounding.h"
#include "renderer/shapes/box.h"
#include "renderer/shapes/csg_sweep.h"
#include "renderer/shapes/line_box.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {
CsgShape::CsgShape(const CsgTree& tree, CsgTree::Node root) : gates_(tree, root), table_(gates_) {
  // A ray that leaves the surface starts beyond the error of every operand: where faces of several
  // coincide it must leave all of them behind. Bounded for all at once, by the largest entries.
  position_error_.m = {};
  for (const CsgGates::Leaf& leaf : gates_.leaves()) {
    const auto& to = leaf.csg_from_solid.matrix().m;
    const auto& from = leaf.csg_from_solid.inverse_matrix().m;
    const Bounds3& box = gates_.gates()[leaf.gate].bounds;
    for (size_t r = 0; r < 3; ++r) {
      for (size_t c = 0; c < 4; ++c) {
        double sum = c < 3 ? (r == c ? 1 : 0) : std::abs(to[r][3]);
        for (size_t k = 0; k < 3; ++k) sum += std::abs(to[r][k]) * std::abs(from[k][c]);
        double& bound = position_error_.m[r][c];
        bound = std::max(bound, gamma(16) * sum);
      }
      const int axis = static_cast<int>(r);
      const double reach = std::max(std::abs(box.min[axis]), std::abs(box.max[axis]));
      double& constant = position_error_.m[r][3];
      if (std::isfinite(reach)) constant = std::max(constant, gamma(16) * reach);
    }
  }
}

bool CsgShape::find_hit(const Ray& ray, bool any, Hit& hit, TraversalCounters& counters) const {
  const LineInverse inverse(ray.direction);
  const LineRange range = line_range(bounds(), ray, inverse);
  if (range.empty() || range.high < ray.t_min || range.low > std::min(ray.t_max, hit.t))
    return false;
  if (!can_hit(ray)) return false;
  if (table_.is_usable()) {
    const CsgTable::Answer answer =
        table_.closest_hit(gates_, ray, inverse, range, any, hit, counters);
    if (answer != CsgTable::Answer::in_doubt) return answer == CsgTable::Answer::hit;
  }
  const CsgSweep::Lease sweep;
  sweep->gather(gates_, ray, inverse, range, {}, &counters);
  while (const CsgEvent* e = sweep->next(gates_))
    if (is_hit(ray, e->t, e->error, e->inward))
      return take_nearer({e->t, e->u, e->v, 0, e->primitive}, hit);
  return false;
}

bool CsgShape::closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  return find_hit(ray, false, hit, counters);
}

bool CsgShape::any_hit(const Ray& ray, TraversalCounters& counters) const {
  Hit hit;
  return find_hit(ray, true, hit, counters);
}

void CsgShape::crossings(const Ray& ray, const RayError& error,
                         std::vector<SolidEvent>& events) const {
  if (!can_hit(ray)) return;
  const LineInverse inverse(ray.direction);
  const LineRange range = line_range(bounds(), ray, inverse);
  if (range.empty()) return;
  const CsgSweep::Lease sweep;
  sweep->gather(gates_, ray, inverse, range, error, nullptr);
  while (const CsgEvent* e = sweep->next(gates_)) {
    const bool endless = std::isinf(e->t);
    const double reach = std::max(e->t - sweep->low(), sweep->high() - e->t);
    events.push_back({e->t, endless ? 0 : reach, e->inward, e->primitive, e->u, e->v});
  }
}

std::optional<CarvedBox> CsgShape::carved_box() const {
  if (!table_.is_usable() || !table_.is_carved_leaf()) return std::nullopt;
  const auto& leaves = gates_.leaves();
  const auto* const box = dynamic_cast<const Box*>(leaves[0].convex);
  if (!box || leaves[0].moved) return std::nullopt;
  CarvedBox carved{box->bounds(), {}};
  for (size_t i = 1; i < leaves.size(); ++i) {
    const auto* const sphere = dynamic_cast<const Sphere*>(leaves[i].convex);
    if (!sphere || leaves[i].moved) return std::nullopt;
    carved.holes.push_back({sphere->center(), sphere->radius()});
  }
  return carved;
}

uint32_t CsgShape::operand_of(uint32_t primitive) const {
  const auto& leaves = gates_.leaves();
  const auto above = std::upper_bound(
      leaves.begin(), leaves.end(), primitive,
      [](uint32_t p, const CsgGates::Leaf& leaf) { return p < leaf.first_primitive; });
  return static_cast<uint32_t>(above - leaves.begin() - 1);
}

LocalSurface CsgShape::surface(const Ray& ray, const Hit& hit) const {
  const CsgGates::Leaf& leaf = gates_.leaves()[operand_of(hit.primitive)];
  const Hit local_hit{hit.t, hit.u, hit.v, hit.instance, hit.primitive - leaf.first_primitive};
  LocalSurface s;
  if (leaf.moved) {
    const Affine& m = leaf.csg_from_solid.inverse_matrix();
    s = leaf.solid->surface({m(ray.origin), m(ray.direction)}, local_hit);
    take_to_world(leaf.csg_from_solid, leaf.complement, 0, s);
  } else {
    s = leaf.solid->surface(ray, local_hit);
    if (leaf.complement)
      s.geometric_normal = -s.geometric_normal, s.shading_normal = -s.shading_normal;
  }
  for (int r = 0; r < 3; ++r) {
    const auto& row = position_error_.m[static_cast<size_t>(r)];
    s.point_error[r] += row[0] * std::abs(s.point.x) + row[1] * std::abs(s.point.y) +
                        row[2] * std::abs(s.point.z) + row[3];
  }
  s.material += leaf.first_material;
  return s;
}

}  // namespace tessera
