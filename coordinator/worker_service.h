#pragma once

#include <sys/types.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/coordinator_options.h"
#include "coordinator/jobs/active_frame.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/jobs/job_table.h"
#include "coordinator/worker_registry.h"
#include "proto/transport/transport.h"

namespace tessera {

/// Where workers come: takes them in, tells them of jobs, gives them tiles, takes their pixels, and
/// notices when they are no more. Of the coordinator's thread.
class WorkerService {
 public:
  /// `jobs` must outlive it.
  WorkerService(const CoordinatorOptions& options, JobTable& jobs);

  struct Outgoing {
    PeerId peer;
    v1::Envelope message;
  };

  void on_control(const PeerId& peer, const v1::Envelope& message, Time now,
                  const AllowedKey& sender = {});
  void on_peer_gone(const PeerId& peer, Time now, bool welcomed);
  void on_process_ended(pid_t process, bool crashed, const std::string& how, Time now);
  void on_tick(Time now);
  /// So much of everybody's silence, and of the time in which nobody told of progress, does not
  /// count: the coordinator itself did not listen.
  void forgive(Time silence, Time now);
  /// As WorkerRegistry::forgive_keys().
  void forgive_keys() { workers_.forgive_keys(); }
  /// Tells workers what has begun and ended.
  void follow(const JobTable::Changes& changes, Time now);
  /// Gives tiles to whoever has room.
  void fill(Time now);
  /// Gives no more.
  void drain() { draining_ = true; }
  void shut_down(const std::string& reason);

  /// Whoever sends them clears it.
  std::vector<Outgoing>& outgoing() { return outgoing_; }
  std::vector<pid_t> take_stuck_processes();
  const WorkerRegistry& workers() const { return workers_; }
  /// For tests: who was given a tile at this very time though they could have had a more urgent
  /// one, or idles after a tick beside one that they could trace; empty: nobody.
  std::string broken_rule(Time now, bool has_ticked) const;
  /// What it knows of: workers, and counters of tiles and of them.
  void describe(FarmSnapshot& snapshot, Time now) const;
  /// Of how many frames a worker has completed the first tile.
  uint64_t begun_count() const { return frames_begun_; }

 private:
  void on_hello(const PeerId& peer, const v1::Hello& hello, const AllowedKey& sender, Time now);
  /// Whose id a hello claims that is refused for that.
  void tell_taken(const v1::Hello& hello, const AllowedKey& sender, Time now);
  void on_heartbeat(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now);
  void on_band(WorkerRecord& worker, ActiveFrame& job, const v1::TileBand& band, Time now);
  void on_completed(WorkerRecord& worker, ActiveFrame& job, LeaseId lease, Time now);
  void on_tile_failed(WorkerRecord& worker, const v1::TileFailed& failed, Time now);
  void on_ready(WorkerRecord& worker, const v1::SceneReady& ready, Time now);
  void on_unseen(const WorkerRecord& worker, ActiveFrame& job, const v1::SceneReady::Unseen& unseen,
                 Time now);
  void on_scene_failed(WorkerRecord& worker, const v1::SceneFailed& failed, Time now);
  /// The frame that workers know as `job`, if it runs and is the one that they mean.
  ActiveFrame* find_frame(uint64_t job, const std::string& frame_id);
  void on_mismatch(ActiveFrame& job, Mismatch mismatch, Time now);
  /// A worker gave wrong pixels: it or its key is set aside, and what was traced so is traced
  /// again.
  void convict(ActiveFrame& job, const Conviction& conviction, Time now);
  void set_aside(WorkerId id, const std::string& cause, Time now);
  void set_key_aside(const std::string& key, const std::string& cause, Time now);
  void refuse(WorkerRecord& worker, Time now);
  /// Whether what it does counts against its key: where no other of the key is there, which may be
  /// honest, and one of another key is, to go on.
  bool key_is_blamed(const WorkerRecord& worker);
  void fail_undecided(ActiveFrame& job, Time now);
  void abandon_checks(ActiveFrame& job, Time now);
  void fail_or_hold(ActiveFrame& job, const std::string& why);
  /// Puts the job aside where a tile is left that all who are there are barred from.
  void put_barred_aside(ActiveFrame& job);
  std::string name_of(WorkerId id);

  void look_at_jobs(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now);
  static void note_work(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now);
  /// Blames those whose threads hang in what they hold no longer.
  void note_stalls(ActiveFrame& job, const std::vector<Lease>& stalled, Time now);
  void tell(WorkerRecord& worker, const ActiveFrame& job, Time now);
  void fill(WorkerRecord& worker, Time now);
  /// Those that had room when there was nothing for them.
  void fill_idle(Time now);
  bool give_tile(WorkerRecord& worker, Time now);
  /// A part or a copy of another's tile, of a job of at least that priority.
  bool give_at_end(WorkerRecord& worker, const std::vector<ActiveFrame*>& jobs, int32_t least,
                   Time now);
  void give(WorkerRecord& worker, ActiveFrame& job, const Lease& lease, Time now);
  void cancel(const WorkerRecord& worker, const ActiveFrame& job, LeaseId lease);
  /// Takes it back from its worker, unless that has begun.
  void recall(const ActiveFrame& job, const Lease& lease);
  size_t held_by(const WorkerRecord& worker) const;
  /// Whether it may be given tiles at all.
  static bool takes_tiles(const WorkerRecord& worker);
  std::vector<KnownScene> known_scenes(const WorkerRecord& worker) const;
  /// The worker must hold no tile of it.
  void forget_scene(WorkerRecord& worker, uint64_t frame);

  void tell_if_back(WorkerRecord& worker);
  void lose(WorkerRecord& worker, LossCause cause, const std::string& how, Time now);
  /// Fewer workers are there: perhaps none is left that can build the scene of some job.
  void look_for_shortages();
  void note_stuck(const WorkerRecord& worker);
  /// Follows what a scheduler decided. What became free is given out by serve(), which is called
  /// once this is done for all jobs: only then is it known which tile is the most urgent.
  void apply(ActiveFrame& job, const SchedulerEvents& events, Time now);
  /// Gives tiles to those whose tiles were cancelled since, and to those who found none before.
  void serve(Time now);
  void act(ActiveFrame& job, const SchedulerEvents& events, Time now) {
    apply(job, events, now);
    serve(now);
  }
  void judge_failures(WorkerRecord& worker, Time now);
  /// Says in the log, once in a while, what any worker could make it say ever so often.
  static void complain(WorkerRecord& worker, const std::string& what, Time now);
  v1::Envelope& send(const PeerId& peer);

  CoordinatorOptions options_;
  JobTable& jobs_;
  WorkerRegistry workers_;
  std::vector<Outgoing> outgoing_;
  std::vector<pid_t> stuck_;
  FarmSnapshot::Counters counters_;
  std::set<WorkerId> idle_;        ///< who may be given a tile that becomes pending
  std::set<WorkerId> freed_;       ///< whose tiles were cancelled since serve()
  bool some_are_pending_ = false;  ///< tiles of a job that apply() was called for since then
  uint64_t frames_begun_ = 0;
  Tally refusals_, taken_;  ///< as the log tells them
  bool draining_ = false, dismissed_ = false;
};

}  // namespace tessera
