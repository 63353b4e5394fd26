#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include "base/log.h"
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
  double orphan_timeout = 60;
  unsigned protocol_major = 0;
};

ExitCode work(const WorkerCommandOptions& options) {
  if (options.parent > 0 && !die_with_parent(options.parent)) return ExitCode::done;
  catch_interrupts();
  // The terminal's Ctrl-C reaches the whole family; a local worker ends when its parent tells it.
  if (options.parent > 0) std::signal(SIGINT, SIG_IGN);
  configure_logging(options.quiet ? "off" : options.parent > 0 ? "warn" : "info", "worker");
  const auto transport = connect_client(options.endpoint);
  spdlog::info("connecting to {}", options.endpoint);
  WorkerOptions worker;
  worker.threads = options.threads > 0
                       ? options.threads
                       : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  worker.make_renderer = make_tile_renderer;
  worker.orphan_timeout =
      std::chrono::duration_cast<Time>(std::chrono::duration<double>(options.orphan_timeout));
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
      "Ctrl-C or SIGTERM: it gives back its tiles and ends.\n"
      "Example:\n"
      "  tessera worker --connect tcp://127.0.0.1:7117 --threads 8");
  command
      ->add_option("--connect", options->endpoint, "The coordinator, tcp://HOST:PORT or ipc://PATH")
      ->required()
      ->type_name("ENDPOINT");
  command
      ->add_option_function<std::string>(
          "--threads",
          [options](const std::string& text) {
            options->threads = static_cast<int>(parse_whole("--threads", text, 1, 1024));
          },
          "Threads that trace [one a core]")
      ->type_name("N");
  command
      ->add_option_function<std::string>(
          "--orphan-timeout",
          [options](const std::string& text) {
            const double seconds = parse_number("--orphan-timeout", text);
            if (!(seconds > 0 && seconds <= 1e6)) {
              throw usage_error(
                  fmt::format("--orphan-timeout: {}; expected above 0, at most 1000000", text));
            }
            options->orphan_timeout = seconds;
          },
          "End after so long without a word from the coordinator: until then finish its tiles, "
          "keep "
          "them, and connect again [60]")
      ->type_name("SECONDS");
  command->add_flag("--quiet", options->quiet, "Print nothing but errors");
  // Not for users: an empty group hides them from --help.
  command->add_option("--parent", options->parent)->group("");
  command->add_option("--protocol-major", options->protocol_major)->group("");
  command->callback([options, &action] { action = [options] { return work(*options); }; });
}

}  // namespace tessera
