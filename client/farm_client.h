#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "base/silence.h"
#include "client/refusal.h"
#include "client/submitted_job.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/transport.h"
#include "renderer/film/film.h"

namespace tessera {

/// Asks a coordinator one thing after the other and waits for each answer. Throws render_error
/// where it is silent for `patience`, and Error with ExitCode::interrupted once `stop` is set. Used
/// by one thread.
class FarmClient {
 public:
  /// Errors call the coordinator behind `transport` `endpoint`.
  FarmClient(ClientTransport& transport, std::string endpoint, const std::atomic<bool>& stop,
             Time patience = std::chrono::seconds(15));

  /// Hands the job over: returns once the coordinator has all of it, or has refused it.
  /// Interrupted, it has the job cancelled; the error says whether the coordinator has confirmed
  /// that.
  v1::JobStatus submit(const SubmittedJob& job);
  /// Of blobs, by submit().
  uint64_t bytes_sent() const { return bytes_sent_; }
  uint64_t blobs_sent() const { return blobs_sent_; }

  /// The status of that job, after what the query asks for was done; UNKNOWN: there is no such job.
  v1::JobStatus ask(const v1::JobQuery& query);
  /// All jobs. `jobs` of the result has them all.
  v1::JobList list();
  /// Makes a key known by the enrolment token that the connection is made with. Throws usage_error
  /// where that token is not let in, or is none.
  v1::EnrolAnswer enrol(const v1::Enrol& request);
  /// The film of a frame that has ended. Nothing where the coordinator has it not, or no longer:
  /// what has become of the job is to be asked then. Throws render_error where it cannot be
  /// fetched.
  std::optional<Film> fetch_film(const v1::JobStatus& status);
  /// The light of a frame that is being traced, as far as it is done, the rest black; the frame is
  /// the one that the status was asked of. Nothing where none is done, or it is not traced now.
  std::optional<Film> fetch_done(const v1::JobStatus& status, uint32_t frame);
  /// Lets some time pass.
  void wait(Time time);

 private:
  using Handler = std::function<bool(Channel, const v1::Envelope&)>;
  /// Sends `question`, again each second until `done` is true of what came. `interrupted`: what the
  /// error says once `stop` is set.
  void converse(Channel channel, const v1::Envelope& question, const Handler& done,
                const std::string& interrupted = "interrupted");
  /// Has the coordinator cancel what was submitted. Returns what became of it.
  std::string withdraw(uint64_t submission);
  /// Waits a little for messages, and handles them.
  void receive(const Handler& handle, bool& done);

  ClientTransport& transport_;
  std::string endpoint_;
  const std::atomic<bool>& stop_;
  Time patience_;
  Silence silence_;  ///< of the coordinator
  FirstWord first_word_;
  uint64_t bytes_sent_ = 0, blobs_sent_ = 0;
};

}  // namespace tessera
