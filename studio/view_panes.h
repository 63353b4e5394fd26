#pragma once

#include <cstdint>

#include "job/job.h"

namespace tessera {

// The panes of a page, by their numbers: 0 is the one that is worked with, then come those beside
// it, and last those that nobody sees: frames of an animation that are made ahead, and small
// pictures of samples. studio/page/src/state.ts numbers them likewise.
constexpr uint32_t kPanes = 8, kFirstPaneAside = 6;

// The order in which workers serve the studio's jobs. A click is answered before the rest of the
// picture is; which parts a picture shows, once it is there.
constexpr int kPickPriority = kMostPriority;
constexpr int kMainPanePriority = 500;
constexpr int kPartsPriority = 450;
constexpr int kOtherPanePriority = 400;
constexpr int kFullPicturePriority = 100;
constexpr int kPaneAsidePriority = 50;

constexpr int priority_of_pane(uint32_t pane) {
  if (pane >= kFirstPaneAside) return kPaneAsidePriority;
  return pane == 0 ? kMainPanePriority : kOtherPanePriority;
}

}  // namespace tessera
