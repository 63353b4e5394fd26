#pragma once

#include <sys/types.h>

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/monotonic.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/transport.h"
#include "worker/scene_cache.h"
#include "worker/trace_run.h"

namespace tessera {

struct SessionOptions {
  v1::Hello hello;  ///< all of it but the session number
  Time orphan_timeout = Time::max();
  uint64_t blob_budget_bytes = uint64_t{4} << 30;
  SceneCache::Sources blob_sources{};
};

/// What the session wants done, in order.
struct SendMessage {
  Channel channel = Channel::control;
  v1::Envelope message;
};
struct ConnectBulk {
  std::string endpoint;
};
struct Reconnect {};
struct StartBuild {
  std::shared_ptr<const BuildRun> run;
};
struct StartTrace {
  std::shared_ptr<TraceRun> run;
};
struct LookForBlob {
  BlobLookup lookup;
};
struct KeepBlob {
  Digest digest;
  BlobData blob;
};
struct Quit {
  ExitCode exit_code = ExitCode::done;
  std::string reason;
};
using SessionAction = std::variant<SendMessage, ConnectBulk, Reconnect, StartBuild, StartTrace,
                                   LookForBlob, KeepBlob, Quit>;

/// The worker's side of the protocol: says hello until it is welcomed, gathers the job's blobs, has
/// the scene built and tiles traced, sends their bands, tells each second what it holds, and comes
/// anew when the coordinator is silent. Has no socket, thread or clock.
class WorkerSession {
 public:
  WorkerSession(SessionOptions options, Time now);

  void on_message(Channel channel, const v1::Envelope& message, Time now);
  /// What became of a LookForBlob.
  void on_found(const BlobFound& found, Time now);
  void on_built(BuildOutcome outcome, Time now);
  void on_traced(TraceOutcome outcome, Time now);
  /// To be called at next_deadline().
  void on_tick(Time now);
  Time next_deadline() const;
  std::vector<SessionAction> take_actions();
  /// Whether the coordinator has taken this worker in, and is there.
  bool is_welcome() const { return welcomed_; }

  /// Gives back what it holds and says goodbye.
  void leave(const std::string& reason);

 private:
  void say_hello(Time now);
  void on_welcome(const v1::Welcome& welcome, Time now);
  void on_job_start(const v1::JobStart& start, Time now);
  void on_assign(const v1::Assign& assign);
  void cancel_all();
  void forget_job();
  void on_chunk(const v1::BlobChunk& chunk);
  void fetch_more(Time now);
  void scene_failed(const std::string& text, ExitCode code);
  bool scene_bad() const { return failure_.job() != 0; }
  void send_failure();
  void send_ready();
  void send_heartbeat(Time now);
  void send_result(v1::Envelope message);
  v1::Envelope& send(Channel channel = Channel::control);

  SessionOptions options_;
  std::vector<SessionAction> actions_;
  // The connection.
  bool welcomed_ = false;
  v1::Welcome welcome_;
  Time last_heard_, next_hello_, next_heartbeat_{};
  Time hello_pause_;
  // The job.
  uint64_t job_ = 0;  ///< 0: none
  v1::FrameSettings frame_;
  std::string start_;  ///< the JobStart that told it
  bool building_ = false;
  v1::SceneFailed failure_;  ///< job 0: it has not failed
  double build_seconds_ = 0;
  std::shared_ptr<const TileRenderer> renderer_;
  SceneCache cache_;
  std::map<uint64_t, std::shared_ptr<TraceRun>> runs_;  ///< by lease; what the worker holds
  std::deque<v1::Envelope> unsent_;                     ///< results made while not welcomed
};

}  // namespace tessera
