#pragma once

#include <algorithm>

#include "base/monotonic.h"

namespace tessera {

/// How long another side has said nothing while this side listened. Time in which this process did
/// not run, because it was stopped or frozen, tells nothing of the other side and does not count,
/// and after it the other side has time for an answer: what it said meanwhile may still wait to be
/// read, and what was asked before may be lost. Has no clock.
class Silence {
 public:
  explicit Silence(Time now) : since_(now) {}

  void heard(Time now) { since_ = now; }
  /// To be called whenever this side comes to listen, before it asks how long the silence is; `due`
  /// is when it should have come at the latest.
  void listen(Time due, Time now) {
    if (now <= due) return;
    const Time late = now - due;
    since_ = std::min(now, since_ + late + (late < kAbsence ? Time{0} : kAnswer));
  }
  Time length(Time now) const { return now - since_; }
  /// When the silence is that long, if nothing is heard and this side listens.
  Time reaches(Time length) const { return since_ + length; }

 private:
  static constexpr Time kAbsence = std::chrono::seconds(1), kAnswer = std::chrono::seconds(2);

  Time since_;
};

}  // namespace tessera
