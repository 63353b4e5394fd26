#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "base/silence.h"
#include "client/submitted_job.h"
#include "job/job.h"
#include "proto/transport/transport.h"
#include "proto/wire/blob_transfer.h"

namespace tessera {

/// What a coordinator's answer tells of a job.
JobProgress progress_of(const v1::JobStatus& status);

/// The client's side of the protocol: submits a job, serves the blobs that the coordinator lacks,
/// asks how it goes, and fetches the picture. Has no socket, thread or clock.
class JobClient {
 public:
  /// `submission` is drawn at random, not 0.
  JobClient(const JobSpec& job, uint64_t submission, Time now);

  void on_message(Channel channel, const v1::Envelope& message, Time now);
  /// To be called at next_deadline().
  void on_tick(Time now);
  Time next_deadline() const { return next_question_; }
  std::vector<std::pair<Channel, v1::Envelope>> take_outgoing();
  /// Where to send bulk messages, once it is known.
  const std::string& bulk_endpoint() const { return status_.bulk_endpoint(); }
  bool is_traced() const { return status_.state() == v1::JobStatus::RUNNING; }
  /// Whether it sends its scene or fetches its picture.
  bool moves_blobs() const {
    return status_.state() == v1::JobStatus::FETCHING || status_.state() == v1::JobStatus::ENDED;
  }
  /// Ends it as interrupted: at once if the coordinator has not answered yet, else when it agrees,
  /// or soon.
  void cancel(Time now);

  JobProgress progress() const { return progress_of(status_); }
  /// JobProgress::waiting_for while the coordinator has not answered.
  static constexpr char kForCoordinator[] = "the coordinator";
  /// Of the coordinator, while this client listened.
  Time silence(Time now) const { return silence_.length(now); }
  /// Set at the end; taken once. The film is one hole where it could not be fetched.
  std::optional<JobResult> take_result();

 private:
  void on_status(const v1::JobStatus& status, Time now);
  void fetch_film(Time now);
  void finish(JobReport report);
  void finish_interrupted();
  v1::Envelope& send(Channel channel = Channel::control);

  SubmittedJob job_;
  PixelRect crop_;
  AovSet aovs_;
  BlobStore film_;
  BlobFetch fetch_;
  v1::JobStatus status_;
  std::vector<std::pair<Channel, v1::Envelope>> outgoing_;
  Silence silence_;
  Time next_question_;
  int submits_again_ = 3;          ///< for a film that is gone
  std::optional<Time> cancelled_;  ///< when
  std::optional<JobResult> result_;
};

}  // namespace tessera
