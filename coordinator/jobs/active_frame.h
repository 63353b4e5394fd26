#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/jobs/job_rules.h"
#include "coordinator/jobs/packed_scene.h"
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
  /// The two that agree and the one that is wrong are three voters: what is wrong is the key. Else
  /// it is that process alone, since one voter convicts nobody else.
  bool of_key = false;
};

/// The frame's number and its job's.
struct FrameName {
  uint64_t number = 0;  ///< by which workers know it, as a job
  std::string job_id;   ///< of the job, 16 random bytes
};

/// Why workers could not build a frame's scene.
struct SceneFailure {
  v1::SceneFailed::Cause cause = v1::SceneFailed::OTHER;
  std::string text;
};
using SceneFailures = std::map<WorkerId, SceneFailure>;

/// A frame that nobody who is there can render now.
struct Shortage {
  std::string cause;
  /// Another worker may be able to; else people have to look at it first.
  bool until_another_worker = true;
};

/// Where the finished tiles of a frame are kept and found.
struct TileKeeping {
  std::shared_ptr<TileStore> store{};  ///< null: nowhere
  bool must = false;  ///< where a tile cannot be kept, the frame waits until it can be
};

/// One frame, which is what workers know as a job, from its start to its end: its tiles, its film
/// and its numbers. Of the coordinator's thread.
class ActiveFrame {
 public:
  /// `spec`, whose scene is not read, has passed check_job(). `keys` must outlive this. `failures`:
  /// what happened to workers that tried before.
  ActiveFrame(const FrameName& name, JobSpec spec, const PackedScene& scene,
              const TileKeeping& keeping, const JobRules& rules, WorkerKeys& keys, Time now,
              SceneFailures failures = {});

  uint64_t id() const { return id_; }
  /// As of JobStart: what workers say of this frame they say under it.
  const std::string& frame_id() const { return start_.frame_id(); }
  /// Under which its tiles are kept.
  const Digest& key() const { return key_; }
  Time begun() const { return begun_; }
  /// Of its job, as JobTable::by_need() last found it.
  int32_t priority() const { return priority_; }
  void set_priority(int32_t priority) { priority_ = priority; }
  const v1::JobStart& start_message() const { return start_; }
  v1::Assign assignment(const Lease& lease) const;
  /// Notes that a worker could not build the scene. The frame fails once two voters say that the
  /// scene is wrong or, where nobody has built it, that building it ended their process.
  void note_scene_failure(WorkerId worker, SceneFailure failure);
  /// These workers are there. Where all of them have failed to build the scene, the frame is short
  /// of something; where workers are not told apart by keys and one says that the scene is wrong,
  /// it fails.
  void look_for_shortage(const std::vector<WorkerId>& present);
  /// Whether the worker is passed over for this frame: it, or workers of its voter that were lost
  /// while they built the scene, could not build it.
  bool scene_failed_at(WorkerId worker) const {
    return scene_failures_.contains(worker) || lost_voters_.contains(keys_.voter_of(worker));
  }
  /// Whether any worker is passed over.
  bool has_scene_failures() const { return !scene_failures_.empty() || !lost_voters_.empty(); }
  const SceneFailures& scene_failures() const { return scene_failures_; }
  /// Notes that nobody who is there can get on with it.
  void fall_short(Shortage shortage) { shortage_ = std::move(shortage); }
  /// Another worker has come, which may be what it is short of.
  void note_another_worker() {
    if (shortage_ && shortage_->until_another_worker) shortage_.reset();
  }
  /// Why it is to be put aside for now.
  const std::optional<Shortage>& shortage() const { return shortage_; }
  /// Notes that a worker has built the scene: building it does not crash every worker.
  void note_built() { built_ = true; }
  /// Notes that a worker is lost that was told of the job at `told` and has not built its scene.
  /// Where that has happened to too many, each told after the one before was lost, people have to
  /// look at it before it goes on.
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
    std::vector<Conviction> convictions{};
    std::optional<Mismatch> undecided{};  ///< the third differs from both, who are two voters
  };
  Completion complete(uint32_t tile, LeaseId lease, WorkerId from, Time now);
  /// A worker says which region sees only a constant background, and its colour. Completes the
  /// tiles there that nobody has begun: at once where workers are not told apart by keys, else once
  /// two voters have said the same.
  void fill_unseen(const v1::SceneReady::Unseen& unseen, WorkerId from);
  /// Whether it names a colour of this frame's pixels, in finite numbers.
  bool is_sound(const v1::SceneReady::Unseen& unseen) const;
  /// Who said something else of the background before; nobody: all said the same.
  std::optional<WorkerId> contradicted(const v1::SceneReady::Unseen& unseen) const;
  /// These two said so: neither is believed. What was filled is traced, none is filled any more,
  /// and a second worker traces all that either has traced or will.
  SchedulerEvents distrust_unseen(WorkerId one, WorkerId other);
  /// Nobody knows whose pixels these are, and they are not what they should be: the tile is traced
  /// again by whomever.
  SchedulerEvents retrace(uint32_t tile);
  /// Two workers traced it differently: it is traced again by a third.
  SchedulerEvents dispute(Mismatch mismatch, Time now);
  /// All that the worker or, with `by_voter`, its key has traced is traced again by others.
  SchedulerEvents redo_tiles_of(WorkerId worker, bool by_voter);
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
  /// Notes for the times in the report.
  void note_assignment(Time now);
  void note_result(Time now) { last_result_ = now; }
  void note_tile_seconds(uint32_t tile, double seconds);
  /// For the timeline: what `worker` did from `begin` on. `tile` is of no meaning for a scene.
  void note_span(FrameTrace::Kind kind, WorkerId worker, const std::string& name, uint32_t tile,
                 Time begin, Time now);
  const FrameTrace& trace() const { return trace_; }
  std::vector<TileSnapshot> tiles(Time now) const;
  /// Tiles that are done and were traced since it was begun.
  TileWork traced() const;
  /// Ends it: later calls change nothing.
  void fail(ExitCode code, std::string why);
  void interrupt();
  bool ended() const { return ended_ || (scheduler_.finished() && !waits_for_store()); }
  /// The film with holes marked, and the report with its totals filled in. Call once, at the end.
  JobResult finish();

 private:
  struct KeptTiles {
    Digest key;
    std::vector<FinishedTile> tiles{};
  };
  static KeptTiles find_kept(const JobSpec& spec, const PackedScene& scene, TileStore* store);
  ActiveFrame(const FrameName& name, JobSpec& spec, const PackedScene& scene, const KeptTiles& kept,
              const TileKeeping& keeping, const JobRules& rules, WorkerKeys& keys, Time now,
              SceneFailures failures);
  void restore(const std::vector<FinishedTile>& kept);
  void note_cost(const v1::TileBand& band);
  /// Lets a complete tile outlive this process.
  void keep(uint32_t tile);
  /// It is complete no more.
  void reopen(uint32_t tile);

  uint64_t id_;
  TileKeeping keeping_;
  WorkerKeys& keys_;
  Digest key_;  ///< in the store
  int tile_size_ = 0;
  int32_t priority_ = 0;
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
  Time begun_;
  std::optional<Time> first_assignment_, last_result_;
  bool ended_ = false;
  SceneFailures scene_failures_;
  std::optional<Shortage> shortage_;
  std::unordered_set<WorkerId> workers_seen_;
  std::set<WorkerId> lost_builders_;         ///< that did not come back
  std::optional<Time> builder_lost_at_;      ///< the last of them
  std::set<WorkerKeys::Voter> lost_voters_;  ///< one key's, if too many of its workers were lost
  bool built_ = false;
  /// What the first worker said of the background.
  struct UnseenWord {
    WorkerId from = 0;
    PixelRect seen;
    std::vector<float> value;
    bool confirmed = false;  ///< by another voter
  };
  std::optional<UnseenWord> unseen_;
  bool unseen_distrusted_ = false;
  std::set<uint32_t> filled_;        ///< tiles
  std::vector<float> tile_seconds_;  ///< by tile; empty: of none
  FrameTrace trace_;
};

}  // namespace tessera
