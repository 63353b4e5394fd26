#pragma once

#include <vector>

#include "renderer/shapes/csg_event.h"

namespace tessera {

/// Walks along a line through a combination of solids. One per thread and nesting depth; reused.
class CsgSweep {
 public:
  /// Gathers and sorts the crossings of all operands that matter on this line, which is inside the
  /// bounds of the whole in `range`.
  void gather(const CsgGates& gates, const Ray& ray, const LineInverse& inverse,
              const LineRange& range, const RayError& error, TraversalCounters* counters);
  /// The next change of the whole: its event, or null at the end.
  const CsgEvent* next(const CsgGates& gates);
  /// After next(): where the change may truly be.
  double low() const { return low_; }
  double high() const { return high_; }

  /// A sweep that nothing else on this thread uses until the lease ends.
  class Lease {
   public:
    Lease();
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    CsgSweep* operator->() const { return sweep_; }

   private:
    CsgSweep* sweep_;
  };

 private:
  /// What is known of a gate on this line; valid where `line` is the current one's.
  struct State {
    uint64_t line = 0;
    uint32_t count = 0;
    int winding = 0;
    size_t first_event = 0;
  };
  State& state(const CsgGates& gates, uint32_t gate);
  void sort_events();
  void gather_leaf(const CsgGates::Leaf& leaf, const LineRange& range, uint32_t number,
                   const Ray& ray, const RayError& error);
  /// Passes an event; says whether the whole changes there.
  bool pass(const CsgGates& gates, const CsgEvent& event);

  std::vector<CsgEvent> events_;
  std::vector<SolidEvent> leaf_events_;
  std::vector<State> states_;
  uint64_t line_ = 0;
  size_t at_ = 0;
  bool inside_ = false;
  double low_ = 0, high_ = 0;
};

}  // namespace tessera
