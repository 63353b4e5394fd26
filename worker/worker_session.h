#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/silence.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/transport.h"
#include "worker/crash_record.h"
#include "worker/scene_cache.h"
#include "worker/trace_run.h"

namespace tessera {

struct SessionOptions {
  /// All of it; the session number is the last one that a process before this one used under the
  /// same id, else 0.
  v1::Hello hello;
  Time orphan_timeout = Time::max();
  uint64_t blob_budget_bytes = uint64_t{4} << 30;
  SceneCache::Sources blob_sources{};
  CrashedFrames crashed_frames{};
  /// Of results in memory, while the coordinator is away.
  uint64_t result_bytes = uint64_t{256} << 20;
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
/// A result for which there is no room in memory: to be given to on_spooled() once welcome.
struct SpoolResult {
  v1::Envelope result;
};
struct Quit {
  ExitCode exit_code = ExitCode::done;
  std::string reason;
  bool refused = false;  ///< by the coordinator, for good
};
using SessionAction = std::variant<SendMessage, ConnectBulk, Reconnect, StartBuild, StartTrace,
                                   LookForBlob, KeepBlob, SpoolResult, Quit>;

/// How many tiles a worker of that many threads should hold, once memory was too short for
/// `credit`: none that waits; then half as many, down to one.
uint32_t lowered_credit(uint32_t credit, uint32_t threads);

/// The worker's side of the protocol: says hello until it is welcomed, gathers the jobs' blobs, has
/// their scenes built and tiles traced, sends their bands, tells each second what it holds, and
/// comes anew when the coordinator is silent. Has no socket, thread or clock.
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
  /// What it says of itself, and whose jobs it has, or had last; 0: nobody's yet.
  const v1::Hello& hello() const { return options_.hello; }
  uint64_t farm() const { return welcome_.farm(); }

  /// A result of that farm that was spooled, by this process or by one before it under the same id.
  void on_spooled(v1::Envelope result) { send_result(std::move(result)); }
  /// Takes out the results that nobody may have: the coordinator is not there.
  std::vector<v1::Envelope> take_unsent();

  /// Gives back what it has not begun and takes nothing more; the rest is traced and sent.
  void drain(Time now);
  /// Nothing is left of that, and what was traced has come, or the coordinator is not there.
  bool drained() const { return leaves_ && runs_.empty() && (!welcomed_ || results_.empty()); }
  /// Gives back what it holds and says goodbye.
  void leave(const std::string& reason);

 private:
  /// A job whose scene is gathered, built and then traced, or has failed.
  struct Job {
    v1::JobStart start;
    BlobFetch fetch;
    bool building = false;
    v1::SceneFailed failure;  ///< job 0: it has not failed
    double build_seconds = 0;
    std::shared_ptr<const TileRenderer> renderer;
    std::shared_ptr<const BuildRun> run;  ///< while it is being built
    /// Ends what is built of it.
    std::shared_ptr<std::atomic<bool>> dropped = std::make_shared<std::atomic<bool>>(false);

    bool bad() const { return failure.job() != 0; }
    bool fetches() const { return !renderer && !building && !bad(); }
  };

  void say_hello(Time now);
  void on_welcome(const v1::Welcome& welcome, Time now);
  void on_bulk(const v1::Envelope& message, Time now);
  void on_chunk(const v1::BlobChunk& chunk);
  void on_missing(const v1::BlobMissing& missing);
  void on_place(Job& job, const v1::BlobPlace& place);
  void on_job_start(const v1::JobStart& start, Time now);
  void on_assign(const v1::Assign& assign);
  void on_cancel_tile(const v1::CancelTile& cancel);
  void cancel_runs(uint64_t job);
  /// Drops what is built for jobs that are over, except for builds that a job that is still to
  /// be built needs all meshes and pictures too.
  void drop_builds();
  void forget_job(uint64_t job);
  void forget_jobs();
  /// Drops jobs that trace nothing until the scenes of the rest fit.
  bool make_room(const v1::JobStart& start);
  void fetch_more(Job& job, Time now);
  void scene_failed(Job& job, const std::string& text, v1::SceneFailed::Cause cause);
  void send_failure(Job& job);
  void send_ready(const Job& job);
  void send_heartbeat(Time now);
  void send_result(v1::Envelope message);
  struct Result;
  void forget_results(const std::function<bool(const Result&)>& which);
  v1::Envelope& send(Channel channel = Channel::control);

  SessionOptions options_;
  std::vector<SessionAction> actions_;
  // The connection.
  bool welcomed_ = false, leaves_ = false;
  v1::Welcome welcome_;
  Silence silence_;  ///< of the coordinator
  Time next_look_;   ///< at the latest: so that an absence is noticed
  Time next_hello_, next_heartbeat_{};
  Time hello_pause_;
  std::map<uint64_t, Job> jobs_;
  /// Of jobs that are over. The next job often comes with the end of the one before it, and is of
  /// the same meshes.
  struct OrphanedBuild {
    v1::JobStart start;
    std::shared_ptr<const BuildRun> run;
    std::shared_ptr<std::atomic<bool>> dropped;
  };
  std::vector<OrphanedBuild> orphaned_builds_;
  Time next_drop_ = Time::max();    ///< when it is decided about those, if no job comes before
  std::map<uint64_t, int> missed_;  ///< how often a blob of that job was not to be had
  SceneCache cache_;
  using LeaseOfJob = std::pair<uint64_t, uint64_t>;
  std::map<LeaseOfJob, std::shared_ptr<TraceRun>> runs_;  ///< by job and lease; what it holds
  /// What the coordinator may not have yet: made while it was away, or sent just before.
  struct Result {
    uint64_t number = 0;
    v1::Envelope message;
  };
  std::deque<Result> results_;
  uint64_t results_made_ = 0, result_bytes_ = 0;  ///< in all; in results_
};

}  // namespace tessera
