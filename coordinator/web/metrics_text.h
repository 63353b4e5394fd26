#pragma once

#include <string>

#include "base/process_usage.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/web/farm_monitor.h"

namespace tessera {

/// What /metrics tells beside the farm.
struct WebCounts {
  uint64_t requests = 0, previews_encoded = 0;
};

/// Prometheus' text format 0.0.4. docs/operating.md lists the metrics.
std::string metrics_text(const FarmSnapshot& snapshot, const FarmMonitor::Work& work,
                         const WebCounts& web, const ProcessUsage& usage);

}  // namespace tessera
