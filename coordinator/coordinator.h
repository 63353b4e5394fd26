#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/active_job.h"
#include "coordinator/coordinator_options.h"
#include "coordinator/job_queue.h"
#include "coordinator/worker_registry.h"
#include "job/job.h"
#include "proto/transport/transport.h"

namespace tessera {

/// A message to be sent, or to be dropped if that is not possible now.
struct OutgoingMessage {
  Channel channel = Channel::control;
  PeerId peer;
  v1::Envelope message;
};

/// Cuts jobs into tiles, gives them to workers and puts their pixels together, one job after the
/// other. Has no socket, thread or clock: messages and `now` come in, messages go out. Messages may
/// be lost, doubled, late or made up; none makes it throw.
class Coordinator {
 public:
  explicit Coordinator(CoordinatorOptions options);

  /// Queues a job of this process. Throws usage_error if its frame, crop or tile size cannot be.
  uint64_t submit(JobSpec spec, Time now);
  /// Ends it now, as interrupted, with what there is.
  void interrupt(uint64_t job, Time now);
  /// Ends the job that runs, as failed, for a reason outside.
  void fail_job(const std::string& why, Time now);
  /// The result of a job from submit() once it has ended; told once.
  std::optional<JobResult> take_result(uint64_t job);
  JobProgress progress(Time now) const;

  void on_message(Channel channel, const PeerId& peer, const v1::Envelope& message, Time now);
  /// The transport found that this control connection is no more.
  void on_peer_gone(const PeerId& peer, Time now);
  /// A process of this host is no more; `crashed` as in EndedProcess.
  void on_process_ended(pid_t process, bool crashed, const std::string& how, Time now);
  /// To be called at next_deadline().
  void on_tick(Time now);
  Time next_deadline() const { return next_tick_; }

  std::vector<OutgoingMessage> take_outgoing();
  /// Tells every worker to end, and the clients of jobs that have not ended why they do not.
  void shut_down(const std::string& reason);
  /// Processes of this host that hold a tile without progress, or are lost though they did not end:
  /// better killed and replaced.
  std::vector<pid_t> take_stuck_processes();
  /// Adds to the running job's report.
  void note_assembling(Time spent);

  const WorkerRegistry& workers() const { return workers_; }

 private:
  ActiveJob* job() const { return jobs_.active(); }
  void on_hello(const PeerId& peer, const v1::Hello& hello, Time now);
  void on_worker_message(WorkerRecord& worker, const v1::Envelope& message, Time now);
  void on_heartbeat(WorkerRecord& worker, const v1::Heartbeat& heartbeat, Time now);
  void on_band(WorkerRecord& worker, const v1::TileBand& band, Time now);
  void on_tile_failed(WorkerRecord& worker, const v1::TileFailed& failed, Time now);
  void on_ready(WorkerRecord& worker, const v1::SceneReady& ready, Time now);
  void on_mismatch(const Mismatch& mismatch, Time now);
  void fail_undecided(Time now);
  std::string name_of(WorkerId id);
  void on_scene_failed(WorkerRecord& worker, const v1::SceneFailed& failed);
  void on_blob_request(const PeerId& peer, const v1::BlobRequest& request);

  void advance_jobs(Time now);
  void attend_clients(Time now);
  void forward_to_clients();
  void lose(WorkerRecord& worker, LossCause cause, const std::string& how, Time now);
  void note_stuck(const WorkerRecord& worker);
  void act(const SchedulerEvents& events, Time now);
  void judge_failures(WorkerRecord& worker, Time now);
  void fill(Time now);
  void fill(WorkerRecord& worker, Time now);
  void tell_job(WorkerRecord& worker, Time now);
  v1::Envelope& send(const PeerId& peer, Channel channel = Channel::control);

  CoordinatorOptions options_;
  WorkerRegistry workers_;
  JobQueue jobs_;
  std::vector<OutgoingMessage> outgoing_;
  std::vector<pid_t> stuck_;
  Time next_tick_{};
};

}  // namespace tessera
