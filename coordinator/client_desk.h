#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/coordinator_options.h"
#include "job/job.h"
#include "proto/transport/transport.h"
#include "proto/wire/blob_transfer.h"

namespace tessera {

/// What clients asked for: pulls their blobs, answers their questions, and keeps their films until
/// they are fetched. A client that asks no more is gone.
class ClientDesk {
 public:
  explicit ClientDesk(const CoordinatorOptions& options) : options_(options) {}

  struct Outgoing {
    PeerId peer;
    v1::Envelope message;
  };
  /// A submission whose blobs are all here.
  struct Ready {
    uint64_t submission = 0;
    JobSpec spec;
  };

  /// False if the message is none of a client's.
  bool on_control(const PeerId& peer, const v1::Envelope& message, Time now);
  /// Only who was asked knows the submission's number, which must be in the answer.
  void on_chunk(const v1::BlobChunk& chunk, Time now);
  void on_missing(const v1::BlobMissing& missing);
  void on_tick(Time now);

  std::vector<Ready> take_ready();
  std::vector<Outgoing> take_outgoing();
  /// Submissions whose client is gone or took them back.
  std::vector<uint64_t> take_abandoned();

  void refused(uint64_t submission, const Error& error);
  void running(uint64_t submission, const JobProgress& progress);
  void ended(uint64_t submission, const JobResult& result);
  /// Fails what has not ended, for a reason outside.
  void close(const std::string& why);
  /// Of a film that waits to be fetched.
  BlobData find_blob(const Digest& digest) const;

 private:
  void on_submit(const PeerId& peer, const v1::SubmitJob& request, Time now);
  void on_query(const PeerId& peer, const v1::JobQuery& query, Time now);
  void on_release(const v1::JobRelease& release);
  struct Submission {
    PeerId peer;
    v1::SubmitJob request;
    BlobFetch fetch;
    BlobStore blobs;
    v1::JobStatus status;
    BlobData film;
    Digest film_digest;
    Time last_heard{};
    uint64_t bytes = 0;  ///< that it may come to take
  };
  using Submissions = std::map<uint64_t, Submission>;
  Submissions::iterator forget(Submissions::iterator it);
  /// The submission of that number if its blobs are not yet all here; null otherwise.
  Submission* fetching(uint64_t id);
  void advance(uint64_t id, Submission& submission, Time now);
  void answer(const Submission& submission);
  std::optional<JobSpec> read_spec(Submission& submission);
  void log_end(uint64_t id, const JobReport& report) const;
  void fail(Submission& submission, ExitCode code, const std::string& why);

  CoordinatorOptions options_;
  Submissions submissions_;
  uint64_t claimed_bytes_ = 0;  ///< sum over submissions_
  std::vector<Ready> ready_;
  std::vector<Outgoing> outgoing_;
  std::vector<uint64_t> abandoned_;
};

}  // namespace tessera
