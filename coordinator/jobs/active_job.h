#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/jobs/job_rules.h"
#include "coordinator/tiles/assembler.h"
#include "coordinator/tiles/tile_scheduler.h"
#include "coordinator/tiles/tile_store.h"
#include "coordinator/tiles/tile_verifier.h"
#include "job/job.h"

namespace tessera {

/// Under what the tiles of a frame are kept: names all that its pixels depend on. `frame` is
/// settled().
Digest tile_key(const Digest& scene, const v1::FrameSettings& frame, const PixelRect& crop);

/// A worker whose pixels two others contradict.
struct Conviction {
  WorkerId wrong = 0;
  Mismatch dispute;
  WorkerId judge = 0;
};

/// Where the finished tiles of a frame are kept and found.
struct TileKeeping {
  std::shared_ptr<TileStore> store{};  ///< null: nowhere
  bool must = false;  ///< where a tile cannot be kept, the frame waits until it can be
};

/// One frame, which is what workers know as a job, from its start to its end: its tiles, its film
/// and its numbers.
class ActiveJob {
 public:
  /// `spec` has passed check_job().
  ActiveJob(uint64_t id, JobSpec spec, const TileKeeping& keeping, const JobRules& rules, Time now);

  uint64_t id() const { return id_; }
  const v1::JobStart& start_message() const { return start_; }
  v1::Assign assignment(const Lease& lease) const;
  /// Notes that a worker could not build the scene, and ends the job if none can: `present` are the
  /// workers that there are. One alone is not believed as long as another may build it.
  void note_scene_failure(WorkerId worker, ExitCode code, const std::string& why,
                          const std::vector<WorkerId>& present);
  bool scene_failed_at(WorkerId worker) const { return scene_failures_.contains(worker); }
  /// Some worker has built the scene: what may come of it, it ends not every worker.
  void note_built() { built_ = true; }
  /// Notes that a worker is lost that was told of the job at `told` and has not built its scene,
  /// and ends the job where that has happened to too many, each told after the one before was lost.
  void note_lost_builder(WorkerId worker, Time told, Time now);
  BlobData find_blob(const Digest& digest) const { return blobs_.find(digest); }

  TileScheduler& scheduler() { return scheduler_; }
  const TileScheduler& scheduler() const { return scheduler_; }
  Assembler& assembler() { return assembler_; }
  const Assembler& assembler() const { return assembler_; }
  JobReport& report() { return report_; }
  const JobReport& report() const { return report_; }

  /// Takes note of a band that is sound: whose it is, and whether a second worker has now traced
  /// the whole tile too. `was_complete`: the tile, before it.
  SchedulerEvents note_band(const v1::TileBand& band, WorkerId from, bool was_complete);
  /// The tile is complete, the last of it under `lease` of `from`: it is kept, where the job has a
  /// store, and a dispute about it is judged.
  struct Completion {
    SchedulerEvents events;
    std::optional<Conviction> conviction;
    std::optional<Mismatch> undecided;  ///< the third differs from both
  };
  Completion complete(uint32_t tile, LeaseId lease, WorkerId from, Time now);
  /// Completes, as traced by that worker, the tiles that look past everything, as it says.
  void fill_unseen(const v1::SceneReady::Unseen& unseen, WorkerId from);
  /// Who said before what is past everything, and something else; nobody: all said the same.
  std::optional<WorkerId> contradicted(const v1::SceneReady::Unseen& unseen) const;
  /// These two said so: neither is believed. What was filled is traced, none is filled any more,
  /// and a second worker traces all that either has traced or will.
  SchedulerEvents distrust_unseen(WorkerId one, WorkerId other);
  /// Two workers traced it differently: it is traced again by a third.
  SchedulerEvents dispute(Mismatch mismatch, Time now);
  /// All that the worker has traced is traced again by others.
  SchedulerEvents redo_tiles_of(WorkerId worker);
  /// Tries again to keep what the store did not take.
  void keep_rest();
  /// Why tiles are not kept now; empty: they are. Where they must be, no more are to be traced.
  const std::string& store_trouble() const { return store_trouble_; }
  bool waits_for_store() const { return keeping_.must && !(unkept_.empty() && undropped_.empty()); }

  /// There is this worker; one that was there is lost.
  void note_worker(WorkerId worker) {
    workers_seen_.insert(worker);
    lost_builders_.erase(worker);
  }
  void note_lost_worker() { ++report_.workers_lost; }
  /// Notes for the times in the report and the estimate of what remains.
  void note_assignment(Time now);
  void note_result(Time now) { last_result_ = now; }
  void note_tile_seconds(uint32_t tile, double seconds);
  /// For the timeline: what `worker` did from `begin` on. `tile` is of no meaning for a scene.
  void note_span(FrameTrace::Kind kind, WorkerId worker, const std::string& name, uint32_t tile,
                 Time begin, Time now);
  const FrameTrace& trace() const { return trace_; }
  std::vector<TileSnapshot> tiles(Time now) const;
  JobProgress progress(Time now) const;
  /// Ends it: later calls change nothing.
  void fail(ExitCode code, std::string why);
  void interrupt();
  bool ended() const { return ended_ || (scheduler_.finished() && !waits_for_store()); }
  /// The film with holes marked, and the report with its totals filled in. Call once, at the end.
  JobResult finish();

 private:
  ActiveJob(uint64_t id, JobSpec& spec, const TileKeeping& keeping,
            const std::vector<FinishedTile>& kept, const JobRules& rules, Time now);
  void restore(const std::vector<FinishedTile>& kept);
  void note_cost(const v1::TileBand& band);
  /// Lets a complete tile outlive this process.
  void keep(uint32_t tile);
  /// It is complete no more.
  void reopen(uint32_t tile);

  uint64_t id_;
  TileKeeping keeping_;
  Digest key_;  ///< in the store
  int tile_size_ = 0;
  std::vector<uint32_t> unkept_;     ///< complete tiles that the store could not take yet
  std::vector<uint32_t> undropped_;  ///< reopened ones that it could not drop; before the former
  std::string store_trouble_;
  v1::JobStart start_;
  BlobStore blobs_;  ///< the scene's, and the scene itself
  uint32_t samples_;
  Assembler assembler_;
  TileScheduler scheduler_;
  TileVerifier verifier_;
  JobReport report_;
  Time submitted_;
  std::optional<Time> first_assignment_, last_result_;
  bool ended_ = false;
  std::map<WorkerId, ExitCode> scene_failures_;
  std::unordered_set<WorkerId> workers_seen_;
  std::set<WorkerId> lost_builders_;     ///< that did not come back
  std::optional<Time> builder_lost_at_;  ///< the last of them
  bool built_ = false;
  /// What the first worker said of what is past everything.
  struct UnseenWord {
    WorkerId from = 0;
    PixelRect seen;
    std::vector<float> value;
  };
  std::optional<UnseenWord> unseen_;
  bool unseen_distrusted_ = false;
  std::set<uint32_t> filled_;        ///< tiles
  std::vector<float> tile_seconds_;  ///< by tile; empty: of none
  FrameTrace trace_;
};

}  // namespace tessera
