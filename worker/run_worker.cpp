#include "worker/run_worker.h"

#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <optional>
#include <random>
#include <utility>
#include <variant>

#include "base/log.h"
#include "base/plural.h"
#include "base/process_usage.h"
#include "base/silence.h"
#include "base/tally.h"
#include "base/version.h"
#include "proto/transport/listening.h"
#include "proto/wire/frame.h"
#include "proto/wire/version.h"
#include "worker/blob_loader.h"
#include "worker/render_service.h"
#include "worker/session_spool.h"
#include "worker/worker_session.h"

namespace tessera {
namespace {

// What it takes at one time: most of it waits, where tiles come back at once.
constexpr uint32_t kTilesPerThread = 5;
// How soon `stop` is noticed.
constexpr Time kLongestWait = std::chrono::milliseconds(100);
// Where one takes longer, this process did not run.
constexpr Time kLongestRound = std::chrono::seconds(1);
// Then it is told what is known of a coordinator that has not answered.
constexpr Time kFirstPatience = std::chrono::seconds(2);
// After so many messages, what is traced and what is due by the clock has its turn.
constexpr size_t kMessagesPerRound = 256;

std::string host_name() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "unknown";
  return name.data();
}

std::string numerics_of(const WorkerOptions& options) {
  return options.numerics_id.empty() ? kNumericsId : options.numerics_id;
}

std::unique_ptr<ResultSpool> open_spool(const WorkerOptions& options) {
  if (options.spool_folder.empty()) return nullptr;
  return std::make_unique<ResultSpool>(options.spool_folder, options.spool_budget_bytes,
                                       numerics_of(options));
}

/// As who `before` was, where there was one.
v1::Hello make_hello(const WorkerOptions& options,
                     const std::optional<ResultSpool::Origin>& before) {
  std::random_device random;
  v1::Hello hello;
  hello.set_protocol_major(options.protocol_major ? options.protocol_major : kProtocolMajor);
  hello.set_protocol_minor(kProtocolMinor);
  hello.set_build(kBuild);
  hello.set_numerics_id(numerics_of(options));
  hello.set_worker_id(before ? before->worker_id : (uint64_t{random()} << 31 | random()) | 1);
  hello.set_session(before ? before->session : 0);
  hello.set_host(host_name());
  hello.set_process_id(static_cast<uint32_t>(getpid()));
  const auto threads = static_cast<uint32_t>(std::max(1, options.threads));
  hello.set_threads(threads);
  uint32_t credit = threads * kTilesPerThread;
  for (uint64_t i = 0; i < options.memory_kills && credit > 1; ++i) {
    credit = lowered_credit(credit, threads);
  }
  hello.set_credit(credit);
  return hello;
}

/// The socket's side of a worker.
class WorkerLoop {
 public:
  WorkerLoop(ClientTransport& transport, const WorkerOptions& options)
      : transport_(transport),
        service_(
            options.make_renderer, options.threads, [&transport] { transport.wake(); },
            options.crash_record),
        loader_(options.cache, [&transport] { transport.wake(); }),
        spool_(open_spool(options)),
        session_(session_options(options, spool_.get()), monotonic_now()),
        endpoint_(options.endpoint),
        threads_(options.threads),
        idle_timeout_(options.idle_timeout),
        drain_(options.drain) {}

  WorkerEnd run(const std::atomic<bool>& stop) {
    while (true) {
      if (perform()) break;
      if (stop && !drain_until_) {
        drain_until_ = monotonic_now() + drain_;
        session_.drain(monotonic_now());
      }
      if (drain_until_ && (session_.drained() || monotonic_now() >= *drain_until_)) {
        session_.leave("stopped");
        perform();
        break;
      }
      if (is_idle()) {
        session_.leave("idle");
        perform();
        break;
      }
      const Time begin = monotonic_now();
      const Time pause = std::clamp(session_.next_deadline() - begin, Time{0}, kLongestWait);
      // Rounded up, or the last millisecond would be spent in circles.
      transport_.wait(std::chrono::ceil<std::chrono::milliseconds>(pause));
      idle_.listen(begin + kLongestRound, monotonic_now());
      receive();
      while (const auto found = loader_.take_found()) session_.on_found(*found, monotonic_now());
      while (auto built = service_.take_built()) {
        --underway_;
        session_.on_built(std::move(*built), monotonic_now());
      }
      while (auto traced = service_.take_traced()) {
        --underway_;
        session_.on_traced(std::move(*traced), monotonic_now());
      }
      if (session_.next_deadline() <= monotonic_now()) session_.on_tick(monotonic_now());
      tell_connection();
      tell_silence();
    }
    if (spool_) leave_results();
    // Nothing waits for the tiles any more.
    session_.leave(end_.reason);
    return end_;
  }

 private:
  static SessionOptions session_options(const WorkerOptions& options, const ResultSpool* spool) {
    SessionOptions result;
    result.hello = make_hello(options, spool ? spool->origin() : std::nullopt);
    if (options.crash_record) result.crashed_frames = options.crash_record->crashed_frames();
    result.orphan_timeout = options.orphan_timeout;
    result.blob_sources = {options.cache != nullptr, options.shares_memory, options.at_hand};
    result.result_bytes = options.result_bytes;
    return result;
  }

  void leave_results() {
    const SpooledResults results = spool_unsent(session_, *spool_);
    if (results.kept > 0) {
      spdlog::info("{} of results that nobody took kept for the next worker",
                   counted(results.kept, "message"));
    }
    if (results.dropped > 0) {
      spdlog::info("{} of results that nobody took dropped", counted(results.dropped, "message"));
    }
  }

  void receive() {
    for (size_t i = 0; i < kMessagesPerRound; ++i) {
      const auto received = transport_.receive();
      if (!received) return;
      if (received->channel == Channel::bulk) idle_.heard(monotonic_now());
      const auto message = decode(received->bytes, max_message_bytes(received->channel));
      if (message) {
        session_.on_message(received->channel, *message, monotonic_now());
      } else {
        const auto count = garbage_.note(monotonic_now());
        if (count) spdlog::warn("dropped {} that cannot be read", counted(*count, "message"));
      }
    }
  }

  bool is_idle() {
    if (underway_ > 0) idle_.heard(monotonic_now());
    return idle_timeout_ != Time::max() && idle_.length(monotonic_now()) > idle_timeout_;
  }

  void tell_connection() {
    const auto trouble = transport_.trouble();
    const std::string why = trouble ? trouble->why : "";
    if (why != std::exchange(told_trouble_, why) && !why.empty()) {
      spdlog::warn("no connection to the coordinator: {}", why);
    }
    if (session_.is_welcome() == std::exchange(told_welcome_, session_.is_welcome())) return;
    if (told_welcome_) {
      const size_t count = spool_ ? hand_in_spooled(session_, *spool_) : 0;
      if (count > 0)
        spdlog::info("handed in {} that {} kept on disk", counted(count, "message"),
                     count == 1 ? "was" : "were");
      spdlog::info("connected, with {}", counted(threads_, "thread"));
    } else {
      spdlog::info("the coordinator is silent; connecting again");
    }
  }

  /// Once: it may be starting, so that this is no error.
  void tell_silence() {
    if (told_welcome_ || monotonic_now() < look_for_coordinator_) return;
    look_for_coordinator_ = Time::max();
    if (!nobody_listens(transport_.resolved_endpoint().value_or(endpoint_))) return;
    spdlog::warn("nothing listens at {}; trying again", with_address(endpoint_, transport_));
  }

  /// True once the session wants to end.
  bool perform() {
    for (SessionAction& action : session_.take_actions()) {
      if (auto* message = std::get_if<SendMessage>(&action)) {
        if (message->message.has_heartbeat()) {
          message->message.mutable_heartbeat()->set_resident_bytes(process_usage().resident_bytes);
        }
        transport_.send(message->channel, encode(message->message));
      } else if (auto* bulk = std::get_if<ConnectBulk>(&action)) {
        transport_.connect_bulk(bulk->endpoint);
      } else if (std::get_if<Reconnect>(&action)) {
        transport_.reconnect();
      } else if (auto* build = std::get_if<StartBuild>(&action)) {
        ++underway_;
        service_.build(std::move(build->run));
      } else if (auto* trace = std::get_if<StartTrace>(&action)) {
        ++underway_;
        service_.trace(std::move(trace->run));
      } else if (auto* look = std::get_if<LookForBlob>(&action)) {
        loader_.look(look->lookup);
      } else if (auto* keep = std::get_if<KeepBlob>(&action)) {
        loader_.keep(keep->digest, std::move(keep->blob));
      } else if (auto* spool = std::get_if<SpoolResult>(&action)) {
        if (spool_) spool_->keep(session_.hello(), session_.farm(), spool->result);
      } else if (auto* quit = std::get_if<Quit>(&action)) {
        // Who is refused has nothing to hand in.
        if (spool_ && quit->refused) spool_->clear();
        end_ = {quit->exit_code, quit->reason};
        const auto trouble = transport_.trouble();
        if (trouble) end_.reason += ": " + trouble->why;
        return true;
      }
    }
    return false;
  }

  ClientTransport& transport_;
  RenderService service_;
  BlobLoader loader_;
  std::unique_ptr<ResultSpool> spool_;  ///< null: nowhere
  WorkerSession session_;
  WorkerEnd end_;
  Tally garbage_;
  std::string endpoint_;
  Time look_for_coordinator_ = monotonic_now() + kFirstPatience;
  int threads_;
  Time idle_timeout_;
  Silence idle_{monotonic_now()};  ///< since there was work last
  int underway_ = 0;               ///< builds and traces that have not come back
  Time drain_;
  std::optional<Time> drain_until_;
  bool told_welcome_ = false;
  std::string told_trouble_;
};

}  // namespace

bool die_with_parent(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // It may have ended before that.
  return getppid() == parent;
}

WorkerEnd run_worker(ClientTransport& transport, const WorkerOptions& options,
                     const std::atomic<bool>& stop) {
  return WorkerLoop(transport, options).run(stop);
}

}  // namespace tessera
