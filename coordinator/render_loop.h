#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "coordinator/coordinator_options.h"
#include "coordinator/job.h"
#include "coordinator/local_workers.h"
#include "proto/transport/transport.h"

namespace tessera {

class Coordinator;

/// Moves messages between a ServerTransport, which it owns, and a Coordinator. Used by one thread.
class RenderLoop {
 public:
  RenderLoop(std::unique_ptr<ServerTransport> transport, const CoordinatorOptions& options);
  ~RenderLoop();

  /// Where workers connect to.
  std::string endpoint() const { return transport_->endpoint(); }

  /// Worker processes to watch and replace while this runs; may be null. The caller keeps them.
  void watch(LocalWorkers* workers) { local_workers_ = workers; }

  /// Renders one job to its end, or until `stop` is set (then its end is `interrupted`, and the
  /// film holds what came until then). May be called again for further jobs: workers stay. Throws
  /// Error if the job asks for what cannot be, or if local workers cannot be kept alive.
  JobResult run(JobSpec job, const ProgressCallback& progress, const std::atomic<bool>& stop);

  /// Serves workers and clients that submit jobs until `stop` is set.
  void serve(const std::atomic<bool>& stop);

  /// Tells every worker to end, and gives the message up to 100 ms to leave.
  void shut_down(const std::string& reason);

 private:
  bool step(Time until);
  void deliver();
  void check_local_workers(Time now);

  std::unique_ptr<ServerTransport> transport_;
  std::unique_ptr<Coordinator> coordinator_;
  LocalWorkers* local_workers_ = nullptr;
};

}  // namespace tessera
