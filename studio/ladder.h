#pragma once

#include <cstdint>
#include <optional>

namespace tessera {

/// One picture of a view on its way to the final one. A value.
struct ViewPass {
  int scale = 1;         ///< from 1 to 16: pixels of the pane a side that one traced pixel covers
  uint32_t samples = 1;  ///< a pixel
  friend bool operator==(const ViewPass&, const ViewPass&) = default;
};

/// What a view is to end as.
struct ViewGoal {
  int width = 0, height = 0;  ///< pixels, > 0
  uint32_t samples = 1;       ///< a pixel of the last pass, > 0
  friend bool operator==(const ViewGoal&, const ViewGoal&) = default;
};

/// Pixels a side of a picture at that scale.
constexpr int scaled_side(int side, int scale) { return (side + scale - 1) / scale; }

/// Which passes lead from nothing to the final picture, and how long each is expected to take: the
/// first one as fine as can be had at once, then full size with one sample, then four times the
/// samples each. Learns from passes that ended. A pure function of its calls; not thread-safe.
class PassLadder {
 public:
  /// The first pass is expected to take at most this.
  static constexpr double kFirstPassSeconds = 0.030;
  /// No first pass has a shorter long side, where the pane has not.
  static constexpr int kShortestLongSide = 128;
  static constexpr int kCoarsest = 16;
  static constexpr uint32_t kSampleGrowth = 4;

  ViewPass first(const ViewGoal& goal) const;
  /// The pass after `pass`; nothing where that was the last one.
  static std::optional<ViewPass> next(const ViewGoal& goal, const ViewPass& pass);
  /// Seconds from the order to the last pixel.
  double expected_seconds(const ViewGoal& goal, const ViewPass& pass) const;
  /// Notes what a whole pass took: `overhead` until its first tile was begun, `trace` after that.
  void note(const ViewGoal& goal, const ViewPass& pass, double overhead, double trace);

 private:
  static double sample_count(const ViewGoal& goal, const ViewPass& pass);

  double overhead_ = 0.005;        ///< seconds
  double per_sample_ = 1.0 / 2e6;  ///< seconds of all workers together
};

}  // namespace tessera
