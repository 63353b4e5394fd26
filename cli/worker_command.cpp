#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <memory>
#include <optional>

#include "base/log.h"
#include "base/process.h"
#include "base/shared_arena.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/option_values.h"
#include "proto/transport/zmq_transport.h"
#include "renderer/render/tile_renderer.h"
#include "worker/run_worker.h"

namespace tessera {
namespace {

struct WorkerCommandOptions {
  std::string endpoint;
  int threads = 0;
  int parent = 0;
  bool quiet = false;
  int arena = -1;  ///< a descriptor of SharedArena that was inherited
  unsigned protocol_major = 0;
};

ExitCode work(const WorkerCommandOptions& options) {
  if (options.parent > 0 && !die_with_parent(options.parent)) return ExitCode::done;
  catch_interrupts();
  // The terminal's Ctrl-C reaches the whole family; a local worker ends when its parent tells it.
  if (options.parent > 0) std::signal(SIGINT, SIG_IGN);
  configure_logging(options.quiet ? "off" : options.parent > 0 ? "warn" : "info", "worker");
  WorkerOptions worker;
  worker.threads = options.threads > 0 ? options.threads : core_count();
  check_room_for_threads(worker.threads + kTransportThreads);
  const auto transport = connect_client(options.endpoint);
  spdlog::info("connecting to {}", options.endpoint);
  std::optional<SharedArena> arena;
  if (options.arena >= 0) arena.emplace(options.arena);
  worker.make_renderer = [&arena](const v1::Scene& scene, const BlobStore& blobs,
                                  const v1::FrameSettings& frame, int threads) {
    return make_tile_renderer(scene, blobs, frame, threads, arena ? &*arena : nullptr);
  };
  worker.protocol_major = options.protocol_major;
  const WorkerEnd end = run_worker(*transport, worker, interrupted());
  if (end.exit_code != ExitCode::done) throw Error(end.exit_code, end.reason);
  if (interrupted()) {
    spdlog::info("stopped");
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
      "Example:\n"
      "  tessera worker --connect tcp://127.0.0.1:7117 --threads 8");
  command
      ->add_option("--connect", options->endpoint, "The coordinator, tcp://HOST:PORT or ipc://PATH")
      ->required()
      ->type_name("ENDPOINT");
  add_whole(*command, "--threads", 1, 1024, "Threads that trace [one a core]", options->threads);
  command->add_flag("--quiet", options->quiet, "Print nothing but errors");
  // Not for users: an empty group hides them from --help.
  command->add_option("--parent", options->parent)->group("");
  command->add_option("--arena", options->arena)->group("");
  command->add_option("--protocol-major", options->protocol_major)->group("");
  command->callback([options, &action] { action = [options] { return work(*options); }; });
}

}  // namespace tessera
