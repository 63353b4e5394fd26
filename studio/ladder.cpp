#include "studio/ladder.h"

#include <algorithm>

namespace tessera {
namespace {

/// What is newer counts for so much in the mean of what passes took.
constexpr double kWeightOfNew = 0.5;

}  // namespace

ViewPass PassLadder::first(const ViewGoal& goal) const {
  const int long_side = std::max(goal.width, goal.height);
  ViewPass pass{1, 1};
  while (pass.scale < kCoarsest && expected_seconds(goal, pass) > kFirstPassSeconds &&
         scaled_side(long_side, pass.scale + 1) >= kShortestLongSide) {
    ++pass.scale;
  }
  return pass;
}

std::optional<ViewPass> PassLadder::next(const ViewGoal& goal, const ViewPass& pass) {
  if (pass.scale > 1) return ViewPass{1, 1};
  if (pass.samples >= goal.samples) return std::nullopt;
  return ViewPass{1, std::min(goal.samples, pass.samples * kSampleGrowth)};
}

double PassLadder::sample_count(const ViewGoal& goal, const ViewPass& pass) {
  return double{1} * scaled_side(goal.width, pass.scale) * scaled_side(goal.height, pass.scale) *
         pass.samples;
}

double PassLadder::expected_seconds(const ViewGoal& goal, const ViewPass& pass) const {
  return overhead_ + per_sample_ * sample_count(goal, pass);
}

void PassLadder::note(const ViewGoal& goal, const ViewPass& pass, double overhead, double trace) {
  const auto blend = [](double& mean, double value) { mean += kWeightOfNew * (value - mean); };
  blend(overhead_, overhead);
  blend(per_sample_, trace / sample_count(goal, pass));
}

}  // namespace tessera
