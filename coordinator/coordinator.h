#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/client_service.h"
#include "coordinator/coordinator_options.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/jobs/job_store.h"
#include "coordinator/jobs/job_table.h"
#include "coordinator/worker_service.h"
#include "job/job.h"
#include "proto/transport/transport.h"

namespace tessera {

/// A message to be sent, or to be dropped if that is not possible now.
struct OutgoingMessage {
  Channel channel = Channel::control;
  PeerId peer;
  v1::Envelope message;
};

/// Cuts jobs into tiles, gives them to workers and puts their pixels together: many jobs at a time,
/// of this process and of clients. Has no socket, thread or clock: messages and `now` come in,
/// messages go out. Messages may be lost, doubled, late or made up; none makes it throw.
class Coordinator {
 public:
  /// `store` keeps what clients submit; null: in memory, until the end of this. Throws render_error
  /// where the store cannot be read.
  explicit Coordinator(CoordinatorOptions options, std::shared_ptr<JobStore> store = nullptr);

  /// Queues a job of this process. `tiles`: where its finished tiles are kept and found; null:
  /// nowhere. Throws usage_error if its frame, crop or tile size cannot be, and std::bad_alloc
  /// where it begins at once and there is no memory for it.
  uint64_t submit(JobSpec spec, Time now, std::shared_ptr<TileStore> tiles = nullptr);
  /// Ends it now, as interrupted, with what there is.
  void interrupt(uint64_t job, Time now);
  /// Forgets a job from submit(), wherever it is: nobody takes its result.
  void abandon(uint64_t job);
  /// Ends the jobs that run, as failed, for a reason outside.
  void fail_jobs(const std::string& why, Time now);
  /// The result of a job from submit() once it has ended; told once.
  std::optional<JobResult> take_result(uint64_t job);
  /// The progress of the first job that runs.
  JobProgress progress(Time now) const;
  /// The progress of one job from submit(), which may run beside others. This and the next two tell
  /// nothing before it begins, which it has on return from submit() where fewer than eight others
  /// run, and after it has ended.
  std::optional<JobProgress> progress(uint64_t job, Time now) const;
  std::vector<TileSnapshot> tiles(uint64_t job, Time now) const;
  /// The light so far, valid until the next call that may end the job.
  std::optional<FilmView> film(uint64_t job) const;

  /// `sender`: by whose key, where there are keys.
  void on_message(Channel channel, const PeerId& peer, const v1::Envelope& message, Time now,
                  const AllowedKey& sender = {});
  /// So many keys of workers are let in from now on.
  void set_worker_keys(size_t listed);
  /// The list of keys was read again: what was counted against them counts no more.
  void forgive_keys() { workers_->forgive_keys(); }
  /// The transport found that this control connection is no more. Where not even the welcome could
  /// be sent, its hello was read late: the worker had given it up for another, and is not lost.
  void on_peer_gone(const PeerId& peer, Time now, bool welcomed = true);
  /// A process of this host is no more; `crashed` as in EndedProcess.
  void on_process_ended(pid_t process, bool crashed, const std::string& how, Time now);
  /// To be called at next_deadline().
  void on_tick(Time now);
  Time next_deadline() const { return next_tick_; }

  std::vector<OutgoingMessage> take_outgoing();
  /// From now on gives out no more tiles.
  void drain() { workers_->drain(); }
  /// Whether no worker holds a tile any more, and all that was traced is kept.
  bool drained() const;
  /// Tells every worker to end, and the clients of jobs that have not ended why they do not.
  void shut_down(const std::string& reason);
  /// Processes of this host that hold a tile without progress, or are lost though they did not end:
  /// better killed and replaced.
  std::vector<pid_t> take_stuck_processes() { return workers_->take_stuck_processes(); }
  /// Adds to the report of a running job.
  void note_assembling(uint64_t job, Time spent);

  const WorkerRegistry& workers() const { return workers_->workers(); }

  // For a page or a monitor; all on this thread.
  FarmSnapshot snapshot(Time now) const;
  /// For tests: which rule of scheduling does not hold after an act at that time, or nothing. What
  /// time alone brings, and what is more to be done at once, is looked at after on_tick() alone.
  std::string broken_rule(Time now) const;
  /// Of a frame that is being traced, counted from 0; of any other none.
  std::vector<TileSnapshot> tiles(uint64_t job, uint32_t frame, Time now) const;
  /// The picture so far, no side longer than `most_side` > 0. Nothing where there is none yet.
  /// Takes milliseconds, for a large film that was finished long ago up to a second.
  std::optional<PreviewImage> preview(uint64_t job, uint32_t frame, int most_side);
  /// The number by which users know the frame of a job, which counts from 0 here.
  int32_t number_of(uint64_t job, uint32_t frame) const;
  /// The frames that are being traced: job, and frame counted from 0. Those of this process too.
  std::vector<std::pair<uint64_t, uint32_t>> running_frames() const;
  /// Another number once a job has come or the first tile of a frame is done: what those who watch
  /// want to see at once.
  uint64_t news() const { return jobs_->accepted_count() + workers_->begun_count(); }
  /// The light so far of a frame that is being traced, or that of a client's frame that has ended.
  std::optional<FilmView> film(uint64_t job, uint32_t frame);
  /// The scene of a client's frame with its blobs; nothing where there is no such frame. Throws
  /// Error where the store has it no longer. Reads the store.
  std::optional<std::pair<BlobData, BlobStore>> scene(uint64_t job, uint32_t frame);
  /// Of a frame that is being traced, or of the last ones that were; else null.
  std::shared_ptr<const FrameTrace> trace(uint64_t job, uint32_t frame) const;
  /// Asks and orders as a client does: cancel, pause, resume, priority. UNKNOWN: no such job.
  v1::JobStatus ask(const v1::JobQuery& query, Time now);

 private:
  void on_blob_request(const PeerId& peer, const v1::BlobRequest& request);
  void on_done_tiles_query(const PeerId& peer, const v1::DoneTilesQuery& query);
  /// Tells the jobs how many workers there are.
  void note_workers() const;
  /// Begins and ends what is to, and tells whom it concerns.
  void settle(Time now);
  void collect_outgoing();
  void tell_trouble();

  CoordinatorOptions options_;
  std::unique_ptr<JobTable> jobs_;  ///< apart, so that a coordinator can be moved
  std::unique_ptr<WorkerService> workers_;
  std::unique_ptr<ClientService> clients_;
  std::vector<OutgoingMessage> outgoing_;
  Time next_tick_{};
  std::optional<Time> first_tick_;  ///< about when it was started
  uint64_t bytes_scene_ = 0;
  std::string trouble_;  ///< with the store, as was told last
};

}  // namespace tessera
