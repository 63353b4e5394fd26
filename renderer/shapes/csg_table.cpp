#include "renderer/shapes/csg_table.h"

#include <algorithm>
#include <array>
#include <vector>

#include "renderer/shapes/carved_box.h"
#include "renderer/shapes/csg_event.h"

namespace tessera {
namespace {

/// Whether the whole holds inside the leaves of the set and outside of the others.
bool whole_holds(const CsgGates& gates, uint32_t inside) {
  const auto& all = gates.gates();
  std::vector<uint32_t> counts(all.size());
  // Inputs come after the gate that they belong to.
  for (size_t i = all.size(); i-- > 0;) {
    const CsgGates::Gate& gate = all[i];
    const bool is_leaf = gate.leaf != CsgGates::kNone;
    const bool holds = is_leaf ? (inside >> gate.leaf & 1) != gates.leaves()[gate.leaf].complement
                               : CsgGates::holds(gate, counts[i]);
    if (i == 0) return holds;
    if (holds) ++counts[gate.parent];
  }
  return false;
}

/// The stretch of the line inside of the leaf's solid, which is convex.
bool span_of(const CsgGates::Leaf& leaf, const Ray& ray, SolidSpan& span) {
  if (!leaf.moved) return leaf.convex->span(ray, {}, span);
  const LocalLine line = to_solid(leaf, ray, {});
  return leaf.convex->span(line.ray, line.error, span);
}

/// A crossing, and where it may truly be.
struct Place {
  Place() {}  // not set
  Place(const SolidEvent& e, const LineRange& range, uint32_t number)
      : low(lowest(e, range)),
        high(highest(e, range)),
        t(e.t),
        error(e.error),
        leaf(number),
        primitive(e.primitive) {}

  double low, high, t, error;
  uint32_t leaf, primitive;  ///< the latter within the leaf
};

/// Places in the order of a line.
class Places {
 public:
  void add(const Place& place) {
    size_t at = count_++;
    for (; at > 0 && place.low < places_[at - 1].low; --at) places_[at] = places_[at - 1];
    places_[at] = place;
  }
  /// Whether none may be where the one before it is.
  bool are_apart() const {
    for (size_t i = 1; i < count_; ++i)
      if (!(places_[i - 1].high < places_[i].low)) return false;
    return true;
  }
  const Place* begin() const { return places_; }
  const Place* end() const { return places_ + count_; }

 private:
  Place places_[2 * CsgTable::kMostLeaves];
  size_t count_ = 0;
};

}  // namespace

CsgTable::CsgTable(const CsgGates& gates) {
  const auto& leaves = gates.leaves();
  usable_ = leaves.size() <= kMostLeaves &&
            std::all_of(leaves.begin(), leaves.end(),
                        [](const CsgGates::Leaf& leaf) { return leaf.convex != nullptr; });
  if (!usable_) return;
  const uint32_t sets = 1u << leaves.size();
  needed_ = sets - 1;
  for (uint32_t inside = 0; inside < sets; ++inside) {
    if (!whole_holds(gates, inside)) continue;
    table_ |= uint64_t{1} << inside;
    needed_ &= inside;
    carving_ |= inside;
  }
  carving_ = ~carving_;
  is_carved_ = (needed_ & 1) != 0 && holds(1);
}

/// From where the line enters and leaves leaf 0 alone, if all other leaves are clearly on one side
/// of these points.
CsgTable::Answer CsgTable::by_ends(const CsgGates& gates, const Ray& ray, const SolidSpan& span,
                                   bool any, Hit& hit) const {
  const double from = l1_norm(ray.origin - Point3{}), along = l1_norm(ray.direction);
  const auto& leaves = gates.leaves();
  bool are_outside[2] = {true, true};
  for (uint32_t number = 1; number < leaves.size(); ++number) {
    const CsgGates::Leaf& leaf = leaves[number];
    if (leaf.moved) return Answer::in_doubt;
    uint32_t inside = 0;
    for (int end = 0; end < 2; ++end) {
      const double t = end == 0 ? span.enter.t : span.leave.t;
      const Side side =
          leaf.convex->side_of(ray.at(t), CarvedBox::kDoubt * (from + std::abs(t) * along));
      are_outside[end] &= side == Side::outside;
      inside += side == Side::inside;
    }
    // And so all between, for it is convex.
    if (inside == 2 && (carving_ >> number & 1) != 0) return Answer::miss;
  }
  for (int end = 0; end < (any ? 2 : 1); ++end) {
    const SolidEvent& e = end == 0 ? span.enter : span.leave;
    if (!are_outside[end] || !is_hit(ray, e.t, e.error, end == 0)) continue;
    return take_nearer({e.t, 0, 0, 0, leaves[0].first_primitive + e.primitive}, hit) ? Answer::hit
                                                                                     : Answer::miss;
  }
  return Answer::in_doubt;
}

CsgTable::Answer CsgTable::closest_hit(const CsgGates& gates, const Ray& ray,
                                       const LineInverse& inverse, const LineRange& range, bool any,
                                       Hit& hit, TraversalCounters& counters) const {
  Places places;
  const auto& leaves = gates.leaves();
  for (uint32_t number = 0; number < leaves.size(); ++number) {
    const CsgGates::Leaf& leaf = leaves[number];
    const CsgGates::Gate& gate = gates.gates()[leaf.gate];
    const LineRange own = gate.as_whole ? range : line_range(gate.bounds, ray, inverse);
    ++counters.primitive_tests;
    SolidSpan span;
    if (own.empty() || !span_of(leaf, ray, span)) {
      if (needed_ >> number & 1) return Answer::miss;
      continue;
    }
    // Numbers out of range.
    if (!(span.enter.error >= 0 && span.leave.error >= 0)) return Answer::in_doubt;
    if (number == 0 && is_carved_) {
      // A line that no more than touches it may be outside all along.
      const bool is_inside = highest(span.enter, own) < lowest(span.leave, own);
      const Answer answer = is_inside ? by_ends(gates, ray, span, any, hit) : Answer::in_doubt;
      if (answer != Answer::in_doubt) return answer;
    }
    places.add({span.enter, own, number});
    places.add({span.leave, own, number});
  }
  if (!places.are_apart()) return Answer::in_doubt;
  uint32_t inside = 0;
  for (const Place& place : places) {
    const bool held = holds(inside);
    inside ^= 1u << place.leaf;
    if (holds(inside) == held || !is_hit(ray, place.t, place.error, !held)) continue;
    const uint32_t primitive = leaves[place.leaf].first_primitive + place.primitive;
    return take_nearer({place.t, 0, 0, 0, primitive}, hit) ? Answer::hit : Answer::miss;
  }
  return Answer::miss;
}

}  // namespace tessera
