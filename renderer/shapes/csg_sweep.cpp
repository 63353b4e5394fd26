#include "renderer/shapes/csg_sweep.h"

#include <algorithm>
#include <memory>

namespace tessera {
namespace {

struct Pool {
  std::vector<std::unique_ptr<CsgSweep>> sweeps;
  size_t used = 0;
};
thread_local Pool pool;

}  // namespace

CsgSweep::Lease::Lease() {
  if (pool.used == pool.sweeps.size()) pool.sweeps.push_back(std::make_unique<CsgSweep>());
  sweep_ = pool.sweeps[pool.used++].get();
}

CsgSweep::Lease::~Lease() { --pool.used; }

CsgSweep::State& CsgSweep::state(const CsgGates& gates, uint32_t gate) {
  State& s = states_[gate];
  if (s.line != line_) s = {line_, gates.gates()[gate].initial, 0, 0};
  return s;
}

void CsgSweep::gather_leaf(const CsgGates::Leaf& leaf, const LineRange& range, uint32_t number,
                           const Ray& ray, const RayError& error) {
  leaf_events_.clear();
  if (leaf.moved) {
    const LocalLine line = to_solid(leaf, ray, error);
    leaf.solid->crossings(line.ray, line.error, leaf_events_);
  } else {
    leaf.solid->crossings(ray, error, leaf_events_);
  }
  const size_t before = events_.size();
  for (const SolidEvent& e : leaf_events_) {
    // Numbers out of range: a solid that cannot be told is not there.
    if (std::isnan(e.t) || std::isnan(e.error)) {
      events_.resize(before);
      return;
    }
    events_.push_back({e.t, lowest(e, range), highest(e, range), e.error, number,
                       leaf.first_primitive + e.primitive, e.entering ? 1 : -1,
                       e.entering != leaf.complement, e.u, e.v});
  }
}

void CsgSweep::gather(const CsgGates& gates, const Ray& ray, const LineInverse& inverse,
                      const LineRange& range, const RayError& error, TraversalCounters* counters) {
  events_.clear();
  ++line_;
  at_ = 0;
  inside_ = false;
  if (states_.size() < gates.gates().size()) states_.resize(gates.gates().size());
  const auto& all = gates.gates();
  for (uint32_t i = 0; i < all.size();) {
    const CsgGates::Gate& gate = all[i];
    if (gate.kind != CsgGates::Kind::leaf) {
      state(gates, i).first_event = events_.size();
      // That the line meets the whole is known.
      i = i > 0 && line_range(gate.bounds, ray, inverse).empty() ? gate.end : i + 1;
      continue;
    }
    const CsgGates::Leaf& leaf = gates.leaves()[gate.leaf];
    const size_t before = events_.size();
    if (counters) ++counters->primitive_tests;
    const LineRange own = gate.as_whole ? range : line_range(gate.bounds, ray, inverse);
    if (!own.empty()) gather_leaf(leaf, own, gate.leaf, ray, error);
    ++i;
    // An intersection one of whose solids the line misses is empty: what is below it is not looked
    // at, and what was found below it is dropped, so that the order of operands makes no
    // difference.
    if (events_.size() == before && !leaf.complement && gate.parent != CsgGates::kNone &&
        all[gate.parent].kind == CsgGates::Kind::all) {
      events_.resize(state(gates, gate.parent).first_event);
      i = all[gate.parent].end;
    }
  }
  sort_events();
}

void CsgSweep::sort_events() {
  const auto is_before = [](const CsgEvent& a, const CsgEvent& b) {
    return a.low != b.low ? a.low < b.low : a.t != b.t ? a.t < b.t : a.leaf < b.leaf;
  };
  // Each operand's are in order, and mostly there are few.
  constexpr size_t kFew = 16;
  if (events_.size() > kFew) {
    std::sort(events_.begin(), events_.end(), is_before);
    return;
  }
  for (size_t i = 1; i < events_.size(); ++i) {
    if (!is_before(events_[i], events_[i - 1])) continue;
    const CsgEvent event = events_[i];
    size_t at = i;
    do {
      events_[at] = events_[at - 1];
    } while (--at > 0 && is_before(event, events_[at - 1]));
    events_[at] = event;
  }
}

bool CsgSweep::pass(const CsgGates& gates, const CsgEvent& event) {
  const CsgGates::Leaf& leaf = gates.leaves()[event.leaf];
  State& own = state(gates, leaf.gate);
  const bool was_inside = own.winding > 0;
  own.winding += event.turn;
  bool holds = own.winding > 0;
  if (holds == was_inside) return false;
  holds = holds != leaf.complement;
  uint32_t gate = gates.gates()[leaf.gate].parent;
  while (gate != CsgGates::kNone) {
    const CsgGates::Gate& above = gates.gates()[gate];
    State& s = state(gates, gate);
    const bool held = CsgGates::holds(above, s.count);
    s.count += holds ? 1 : -1;
    if (CsgGates::holds(above, s.count) == held) return false;
    gate = above.parent;
  }
  inside_ = !inside_;
  return true;
}

const CsgEvent* CsgSweep::next(const CsgGates& gates) {
  while (at_ < events_.size()) {
    // All events that may be at one place.
    const size_t begin = at_;
    low_ = events_[begin].low;
    high_ = events_[begin].high;
    while (++at_ < events_.size() && events_[at_].low <= high_)
      high_ = std::max(high_, events_[at_].high);
    const auto first = events_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = events_.begin() + static_cast<std::ptrdiff_t>(at_);
    const bool before = inside_;
    // From inside, what can add to the whole comes first, so that no gap opens between solids that
    // touch; from outside what takes away does, so that no sliver remains. Then the whole changes
    // at most once.
    if (at_ - begin > 1) {
      std::sort(first, last, [before](const CsgEvent& a, const CsgEvent& b) {
        if (a.inward != b.inward) return a.inward == before;
        return a.t != b.t ? a.t < b.t : a.primitive < b.primitive;
      });
    }
    const CsgEvent* change = nullptr;
    for (auto e = first; e != last; ++e)
      if (pass(gates, *e)) change = &*e;
    if (inside_ != before) return change;
  }
  return nullptr;
}

}  // namespace tessera
