#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "coordinator/tiles/tile_store.h"
#include "front/farm_connection.h"
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
  /// From now on `done` is called, on the thread that runs, with tiles of the running frame a few
  /// times a second; empty: no more.
  virtual void watch_tiles(TileCallback done) = 0;
  /// Where finished tiles of jobs to come are kept and found, by those who trace them here.
  virtual void keep_tiles(std::shared_ptr<TileStore>) {}
  /// Moves blobs of jobs to come to where its workers can share them.
  virtual void share(BlobStore&) const {}
  /// Answers its workers for a moment, or until wake(): to be called over and over where nothing is
  /// run for long, as they would take their coordinator for gone. False: it has none to answer.
  virtual bool attend() { return false; }
  /// Ends the attend() under way, or else the next one. Any thread may call this.
  virtual void wake() {}
  /// The largest resident set of a worker process so far; 0 where that is not known.
  virtual uint64_t peak_worker_bytes() const { return 0; }
  /// Nothing more will be asked of it: begins to end, without waiting for that.
  virtual void dismiss() {}
};

struct LocalFarmOptions {
  int workers = 1;  ///< processes on this machine
  int threads = 1;  ///< of each
  bool quiet = false;
  double verify = 0;  ///< as in CoordinatorOptions
  std::string tev{};  ///< where a viewer is, that shows what is traced; empty: nowhere
  /// Called, before workers start, with the folder of the sockets and with these: what a process
  /// that ends at once has to remove.
  std::function<void(const std::string& folder, const std::vector<std::string>& files)>
      made_sockets{};
};
std::unique_ptr<TracingFarm> start_local_workers(const LocalFarmOptions& options);
/// `threads` in this process: the same coordinator and worker code, over memory.
std::unique_ptr<TracingFarm> start_in_process(int threads);
/// A coordinator that serves elsewhere.
std::unique_ptr<TracingFarm> connect_to_farm(const FarmConnection& connection);

}  // namespace tessera
