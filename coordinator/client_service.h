#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "base/tally.h"
#include "coordinator/coordinator_options.h"
#include "coordinator/jobs/job_store.h"
#include "coordinator/jobs/job_table.h"
#include "coordinator/submission.h"
#include "proto/transport/allow_list.h"
#include "proto/transport/transport.h"

namespace tessera {

/// Where clients come: pulls what they submit, has it accepted, and answers their questions. A
/// client that asks no more is gone, and with it what it was submitting, or its job where that does
/// not go on without it. Of the coordinator's thread.
class ClientService {
 public:
  /// `jobs` must outlive it.
  ClientService(const CoordinatorOptions& options, JobTable& jobs, std::shared_ptr<JobStore> store)
      : options_(options), jobs_(jobs), store_(std::move(store)) {}

  struct Outgoing {
    PeerId peer;
    v1::Envelope message;
  };

  /// False if the message is none of a client's.
  bool on_control(const PeerId& peer, const v1::Envelope& message, Time now,
                  const AllowedKey& sender = {});
  /// Only who was asked knows the submission's number, which must be in the answer.
  void on_chunk(const v1::BlobChunk& chunk, Time now);
  void on_missing(const v1::BlobMissing& missing, Time now);
  void on_tick(Time now);
  /// So much of everybody's silence does not count: the coordinator itself did not listen.
  void forgive(Time silence, Time now);
  /// What a client that asks this is answered; what it orders is done.
  v1::JobStatus ask(const v1::JobQuery& query, Time now);
  std::vector<Outgoing> take_outgoing();
  /// Tells clients that wait that nothing will come, for a reason outside.
  void close(const std::string& why);

 private:
  void on_submit(const PeerId& peer, const v1::SubmitJob& request, Time now);
  /// `is_client`: who asks may be the submission's, and not only one who looks.
  void on_query(const PeerId& peer, const v1::JobQuery& query, bool is_client, Time now);
  v1::JobStatus ask(Job& job, const v1::JobQuery& query, Time now);
  static v1::JobStatus ask(Submission& submission, const v1::JobQuery& query);
  void on_list_query(const PeerId& peer, const v1::JobListQuery& query, Time now);
  void on_release(const v1::JobRelease& release);
  void act(Job& job, const v1::JobQuery& query);

  void advance(Submission& submission, Time now);
  /// Submissions of that connection that are under way.
  int64_t count_of(const PeerId& peer) const;
  void accept(Submission& submission, Time now);
  void tell_failure(uint64_t id, const std::string& why, Time now);
  void forget(uint64_t submission);
  /// Of all submissions, with their pictures.
  uint64_t claimed_bytes() const;
  void answer(const PeerId& peer, v1::JobStatus status);
  void answer(const PeerId& peer, const v1::JobQuery& query, Time now);

  CoordinatorOptions options_;
  JobTable& jobs_;
  std::shared_ptr<JobStore> store_;
  std::map<uint64_t, Submission> submissions_;  ///< that are being pulled, or failed in that
  /// Clients with which their jobs end, by submission: when they were heard, and where.
  struct Attached {
    PeerId peer;
    Time last_heard{};
  };
  std::map<uint64_t, Attached> attached_;
  Tally failures_;  ///< of submissions, as the log tells them
  std::vector<Outgoing> outgoing_;
};

}  // namespace tessera
