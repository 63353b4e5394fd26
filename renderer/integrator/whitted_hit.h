#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/integrator/integrator.h"

namespace tessera {

/// A segment that waits until others of its camera ray are followed.
struct WaitingSegment {
  static constexpr uint32_t kNone = ~0u;

  PathSegment segment;
  uint32_t below = kNone;  ///< what is followed after it; of a free place: another one
};
/// The thread's own, for one batch at a time.
std::vector<WaitingSegment>& waiting_segments();

/// What is to be followed from a hit, in this order put aside, so that the last is followed first:
/// what passes straight, what is refracted and what is mirrored.
class Branches {
 public:
  void add(const PathSegment& segment) { segments_[count_++] = segment; }
  std::span<const PathSegment> all() const { return {segments_.data(), count_}; }

 private:
  std::array<PathSegment, 3> segments_;
  size_t count_ = 0;
};

/// What `segment`, which ends in `hit`, brings by itself: direct light with hard shadows, ideal
/// mirrors and clear refraction (Whitted 1980). Adds what is to be followed from there to
/// `branches`. Without kRich the scene must have no rich materials; with it `state` must have the
/// sample's cone.
template <bool kRich>
Color whitted_hit(const Scene& scene, const PathSegment& segment, const Hit& hit,
                  const SampleKey& key, Branches& branches, TraceState& state);

}  // namespace tessera
