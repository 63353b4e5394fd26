#pragma once

#include "renderer/shapes/csg_gates.h"
#include "renderer/shapes/line_box.h"

namespace tessera {

/// A combination of a few convex solids, in which all that holds is looked up by what the point is
/// inside of. It answers where no two crossings are in doubt about their order, which is nearly
/// everywhere, and then what CsgSweep would.
class CsgTable {
 public:
  static constexpr size_t kMostLeaves = 6;

  explicit CsgTable(const CsgGates& gates);
  /// Else the combination is not of that kind.
  bool is_usable() const { return usable_; }

  /// Whether the whole is what is inside of the first leaf and of no other.
  bool is_carved_leaf() const { return is_carved_ && table_ == uint64_t{1} << 1; }

  enum class Answer { miss, hit, in_doubt };
  /// As CsgShape::closest_hit, for a line that is inside the bounds of the whole in `range`; with
  /// `any` any other hit is as good.
  Answer closest_hit(const CsgGates& gates, const Ray& ray, const LineInverse& inverse,
                     const LineRange& range, bool any, Hit& hit, TraversalCounters& counters) const;

 private:
  Answer by_ends(const CsgGates& gates, const Ray& ray, const SolidSpan& span, bool any,
                 Hit& hit) const;
  bool holds(uint32_t inside) const { return table_ >> inside & 1; }

  bool usable_ = false;
  uint64_t table_ = 0;   ///< a bit for each set of leaves that a point may be inside of
  uint32_t needed_ = 0;  ///< leaves without which nothing holds
  /// All is inside of leaf 0, and what is inside of it alone holds.
  bool is_carved_ = false;
  uint32_t carving_ = 0;  ///< leaves whose inside is outside the solid
};

}  // namespace tessera
