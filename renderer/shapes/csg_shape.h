#pragma once

#include <optional>

#include "renderer/shapes/carved_box.h"
#include "renderer/shapes/csg_gates.h"
#include "renderer/shapes/csg_table.h"

namespace tessera {

/// Solids combined by union, intersection and difference, traced by interval algebra: the crossings
/// of all operands along the line are sorted, those whose error bounds overlap are taken as one
/// place, and a place where the combination does not change is no surface (regularised sets: Tilove
/// 1980). No point is ever classified against a solid. So coincident faces make no speckle, and
/// regrouping or reordering operands changes no bit of t.
///
/// Of crossings at one place the surface seen is that whose crossing, in the order of t and then
/// of operands, makes the change. The surface of a subtracted solid shows with its normal
/// turned. Primitives are those of the operands, one after the other in the order of the tree.
///
/// Scratch space is kept per thread and grows to the size of the largest combination met: a query
/// allocates nothing once it is warm.
class CsgShape final : public Solid {
 public:
  CsgShape(const CsgTree& tree, CsgTree::Node root);
  Bounds3 bounds() const override { return gates_.bounds(); }
  bool closest_hit(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  bool any_hit(const Ray& ray, TraversalCounters& counters) const override;
  LocalSurface surface(const Ray& ray, const Hit& hit) const override;
  size_t primitive_count() const override { return gates_.primitive_count(); }
  /// To combine further in one tree is better: operands are then pruned and merged as a whole.
  void crossings(const Ray& ray, const RayError& error,
                 std::vector<SolidEvent>& events) const override;

  /// Where it is nothing but that.
  std::optional<CarvedBox> carved_box() const;

  /// The operand that a hit's primitive belongs to, by number in the order of the tree.
  uint32_t operand_of(uint32_t primitive) const;

 private:
  /// As closest_hit(); with `any` any other hit is as good.
  bool find_hit(const Ray& ray, bool any, Hit& hit, TraversalCounters& counters) const;

  CsgGates gates_;
  CsgTable table_;
  /// |position error| <= matrix |p| + constant, on each axis, for every operand at once.
  Affine position_error_;
};

}  // namespace tessera
