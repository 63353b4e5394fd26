#pragma once

#include <string>
#include <utility>
#include <vector>

#include "job/frame_trace.h"

namespace tessera {

/// A step of this process, in seconds of the trace's clock.
struct TracePhase {
  std::string name;
  double begin = 0, end = 0;
};

/// The timeline in Chrome's trace event format (JSON), which Perfetto and chrome://tracing show:
/// one process a worker, and as many rows of it as tiles that it held at one time.
std::string chrome_trace(const FrameTrace& trace, const std::string& name,
                         const std::vector<TracePhase>& phases = {});

}  // namespace tessera
