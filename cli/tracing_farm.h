#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "job/job.h"

namespace tessera {

/// Whoever traces the frames of one command: started early, to get ready while a long scene
/// is still being read. Used by one thread; its destructor leaves nothing running.
class TracingFarm {
 public:
  virtual ~TracingFarm() = default;
  /// Renders one frame; until `stop` is set.
  virtual JobResult run(JobSpec job, const ProgressCallback& progress,
                        const std::atomic<bool>& stop) = 0;
  /// The largest resident set of a worker process so far; 0 where that is not known.
  virtual uint64_t peak_worker_bytes() const { return 0; }
  /// Nothing more will be asked of it: begins to end, without waiting for that.
  virtual void dismiss() {}
};

/// `workers` processes on this machine, `threads` each.
std::unique_ptr<TracingFarm> start_local_workers(int workers, int threads, bool quiet = false);
/// `threads` in this process: the same coordinator and worker code, over memory.
std::unique_ptr<TracingFarm> start_in_process(int threads);
/// The coordinator that serves at `endpoint`.
std::unique_ptr<TracingFarm> connect_to_farm(const std::string& endpoint);

}  // namespace tessera
