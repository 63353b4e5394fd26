#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <thread>

#include "base/json_log.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/process.h"
#include "base/process_usage.h"
#include "base/shared_arena.h"
#include "base/signal_stack.h"
#include "base/weak_cache.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/log_format.h"
#include "front/farm_connection.h"
#include "front/option_values.h"
#include "renderer/render/tile_renderer.h"
#include "worker/crash_record.h"
#include "worker/run_worker.h"

namespace tessera {
namespace {

constexpr uint64_t kDefaultCacheBudget = uint64_t{10} << 30;

struct WorkerCommandOptions {
  FarmConnection connection;
  int threads = 0;
  std::string cache;
  std::optional<uint64_t> cache_budget;
  int parent = 0;
  bool quiet = false, json_log = false;
  int arena = -1;  ///< a descriptor of SharedArena that was inherited
  int nice = 0;    ///< levels by which this process is less urgent than its parent
  Time orphan_timeout = std::chrono::seconds(60);
  Time idle_timeout = Time::max();
  unsigned protocol_major = 0;
  int crash_record = -1;               ///< a descriptor of CrashRecord, after a crash
  std::optional<uint32_t> crash_seed;  ///< building a frame of this seed crashes, for tests
};

constexpr uint32_t kMostCrashesInVain = 10;

/// Adds an option of seconds.
void add_timeout(CLI::App& command, const std::string& name, const std::string& description,
                 Time& value) {
  command
      .add_option_function<std::string>(
          name,
          [name, &value](const std::string& text) {
            const double seconds = parse_number(name, text);
            if (!(seconds > 0 && seconds <= 1e6)) {
              throw usage_error(
                  fmt::format("{}: {}; expected above 0, at most 1000000", name, text));
            }
            value = std::chrono::duration_cast<Time>(std::chrono::duration<double>(seconds));
          },
          description)
      ->type_name("SECONDS");
}

/// Tells the log of the crash before this start, if there was one, and waits the longer the more
/// there were. Throws render_error where that is in vain.
void go_on_after_crash(const CrashRecord& record) {
  if (!record.last_crash()) return;
  spdlog::error("the worker crashed with {}; it was started anew", *record.last_crash());
  const uint32_t crashes = record.crashes_in_vain();
  if (crashes >= kMostCrashesInVain) {
    throw render_error(fmt::format(
        "the worker crashed {} times without tracing a tile, the last time with {}; expected it to "
        "work",
        crashes, *record.last_crash()));
  }
  constexpr Time kFirstPause = std::chrono::milliseconds(50), kLook = std::chrono::milliseconds(10);
  const Time end = monotonic_now() + (crashes < 2 ? Time{0} : kFirstPause * (1 << (crashes - 2)));
  while (monotonic_now() < end && !interrupted()) std::this_thread::sleep_for(kLook);
}

ExitCode work(const WorkerCommandOptions& options) {
  if (options.parent > 0 && !die_with_parent(options.parent)) return ExitCode::done;
  catch_interrupts();
  lower_priority(options.nice);
  // A local worker that ends in any way is replaced by its parent, which tells its coordinator.
  const SignalStack stack;
  std::optional<CrashRecord> crashes;
  if (options.crash_record >= 0) {
    crashes.emplace(options.crash_record);
  } else if (options.parent == 0) {
    crashes.emplace();
  }
  if (crashes) crashes->start_anew_after_crashes(interrupted());
  // The terminal's Ctrl-C reaches the whole family; a local worker ends when its parent tells it.
  if (options.parent > 0) std::signal(SIGINT, SIG_IGN);
  configure_logging(options.quiet ? "off" : options.parent > 0 ? "warn" : "info", "worker");
  if (options.json_log) log_as_json();
  if (crashes) go_on_after_crash(*crashes);
  WorkerOptions worker;
  worker.threads = options.threads > 0 ? options.threads : core_count();
  check_room_for_threads(worker.threads + kTransportThreads);
  std::optional<SharedArena> arena;
  if (options.arena >= 0) arena.emplace(options.arena);
  WeakCache trees;
  const Sharing sharing{.arena = arena ? &*arena : nullptr, .live = &trees};
  worker.make_renderer = [&](const v1::Scene& scene, const BlobStore& blobs,
                             const v1::FrameSettings& frame, int threads) {
    if (options.crash_seed == frame.seed()) std::raise(SIGSEGV);
    return make_tile_renderer(scene, blobs, frame, threads, sharing);
  };
  worker.crash_record = crashes ? &*crashes : nullptr;
  worker.endpoint = options.connection.endpoint;
  worker.shares_memory = options.connection.endpoint.starts_with("ipc://");
  if (!options.cache.empty()) {
    const uint64_t budget = options.cache_budget.value_or(kDefaultCacheBudget);
    worker.cache = std::make_shared<BlobCache>(options.cache, budget);
    worker.spool_folder = options.cache;
    worker.spool_budget_bytes = budget;
  } else if (options.cache_budget) {
    throw usage_error("--cache-budget: is for --cache; expected that beside it");
  }
  worker.memory_kills = memory_kills();
  if (worker.memory_kills > 0) {
    spdlog::warn("this memory group has killed {} for want of memory: fewer tiles at one time",
                 counted(worker.memory_kills, "worker"));
  }
  // A parent coordinates: it comes back from long work, and where it ends so does this process.
  worker.orphan_timeout = options.parent > 0 ? Time::max() : options.orphan_timeout;
  worker.idle_timeout = options.idle_timeout;
  worker.protocol_major = options.protocol_major;
  const auto transport = connect(options.connection);
  spdlog::info("connecting to {}", options.connection.endpoint);
  const WorkerEnd end = run_worker(*transport, worker, interrupted());
  if (end.exit_code != ExitCode::done) {
    throw Error(end.exit_code, fmt::format("{}: {}", worker.endpoint, end.reason));
  }
  if (interrupted()) {
    spdlog::info("stopped");
  } else if (end.reason.empty()) {
    spdlog::info("stopped: there was nothing to trace");
  } else {
    spdlog::info("the coordinator has ended: {}", end.reason);
  }
  return end.exit_code;
}

}  // namespace

void add_worker_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<WorkerCommandOptions>();
  CLI::App* command = app.add_subcommand("worker", "Trace tiles for a coordinator");
  command->footer(
      "Connects again whenever the connection is lost. Give every machine of a farm one worker.\n"
      "Ctrl-C or SIGTERM: it gives back what it has not begun, traces the rest, and ends; a second "
      "one\n"
      "ends it at once.\n"
      "Example:\n"
      "  tessera worker --connect tcp://127.0.0.1:7117 --threads 8\n"
      "Where the coordinator has a list of keys, also --key and --server-key: see 'tessera help "
      "keygen'.");
  OptionList list;
  add_connection_options(list, options->connection);
  add_options(*command, list);
  command->get_option("--connect")->required();
  add_whole(*command, "--threads", 1, 1024, "Threads that trace [one a core]", options->threads);
  command
      ->add_option(
          "--cache", options->cache,
          "Keep what scenes are made of in this folder, so that it is never sent again, and "
          "results that no coordinator took; workers of one machine may share it [nowhere]")
      ->type_name("DIR");
  command
      ->add_option_function<std::string>(
          "--cache-budget",
          [options](const std::string& text) {
            options->cache_budget = parse_bytes("--cache-budget", text);
          },
          "What the cache may come to take, such as 500M or 10G; what was used longest ago goes "
          "first [10G]")
      ->type_name("BYTES");
  add_timeout(*command, "--orphan-timeout",
              "End after so long without a word from the coordinator: until then finish its tiles, "
              "keep them, and connect again [60]",
              options->orphan_timeout);
  add_timeout(*command, "--idle-timeout",
              "End, with exit code 0, after so long without anything to trace [never]",
              options->idle_timeout);
  add_log_format(*command, options->json_log);
  command->add_flag("--quiet", options->quiet, "Print nothing but errors");
  // Not for users: an empty group hides them from --help.
  command->add_option("--parent", options->parent)->group("");
  command->add_option("--arena", options->arena)->group("");
  command->add_option("--nice", options->nice)->group("");
  command->add_option("--protocol-major", options->protocol_major)->group("");
  command->add_option("--crash-record", options->crash_record)->group("");
  command->add_option("--crash-seed", options->crash_seed)->group("");
  command->callback([options, &action] { action = [options] { return work(*options); }; });
}

}  // namespace tessera
