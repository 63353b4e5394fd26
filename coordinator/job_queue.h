#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>

#include "base/monotonic.h"
#include "coordinator/active_job.h"
#include "coordinator/client_desk.h"
#include "coordinator/coordinator_options.h"
#include "job/job.h"

namespace tessera {

/// Jobs one after the other, in the order in which they came: of this process, and of clients.
class JobQueue {
 public:
  explicit JobQueue(const CoordinatorOptions& options) : options_(options), clients_(options) {}

  /// Queues a job of this process. Throws usage_error if its frame, crop or tile size cannot be.
  uint64_t submit(JobSpec spec) { return enqueue(std::move(spec), 0); }
  /// Ends it, as interrupted, with what there is: at once if it is queued, else at end_active().
  void interrupt(uint64_t job, Time now);
  /// The result of a job from submit() once it has ended; told once.
  std::optional<JobResult> take_result(uint64_t job);

  /// The job that runs, or has ended and waits for end_active(); null: none.
  ActiveJob* active() const { return active_.get(); }
  /// Files the result of the job that ran.
  void end_active(uint64_t workers_seen, uint64_t workers_lost);
  /// Starts the next job if none runs. Whether it did.
  bool start_next(Time now);

  ClientDesk& clients() { return clients_; }
  /// Queues the jobs that clients have completed, and drops those that they gave up.
  void attend_clients();
  /// Tells the client of the running job how it goes.
  void tell_client(const JobProgress& progress);
  /// What workers or clients may fetch; `of_active`: it is the running job's.
  struct FoundBlob {
    BlobData data;
    bool of_active = false;
  };
  FoundBlob find_blob(const Digest& digest) const;

 private:
  struct Queued {
    uint64_t id = 0;
    uint64_t submission = 0;  ///< 0: of this process
    JobSpec spec;
  };
  uint64_t enqueue(JobSpec spec, uint64_t submission);

  CoordinatorOptions options_;
  ClientDesk clients_;
  std::deque<Queued> queue_;
  std::unique_ptr<ActiveJob> active_;
  uint64_t submission_ = 0;                ///< of active_
  std::map<uint64_t, JobResult> results_;  ///< of jobs of this process
  uint64_t jobs_queued_ = 0;
};

}  // namespace tessera
