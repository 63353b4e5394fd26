#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "base/log.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/job_name.h"
#include "cli/say.h"
#include "coordinator/render_loop.h"
#include "coordinator/store/sqlite_job_store.h"
#include "proto/transport/zmq_transport.h"

namespace tessera {
namespace {

/// How long tiles that are being traced may take, once it is told to end.
constexpr Time kDrain = std::chrono::seconds(10);

struct ServeOptions {
  std::string endpoint = kDefaultEndpoint;
  std::string http, store;
};

ExitCode serve(const ServeOptions& options) {
  if (!options.http.empty()) throw usage_error("--http: does not exist yet in this version");
  catch_interrupts();
  configure_logging("info", "serve");
  std::shared_ptr<JobStore> store;
  if (!options.store.empty()) store = std::make_shared<SqliteJobStore>(options.store);
  RenderLoop loop(bind_server(options.endpoint), CoordinatorOptions{}, std::move(store));
  say("serving at {}\n", loop.endpoint());
  std::fflush(stdout);
  // What is traced while no store keeps it is lost in any case.
  loop.serve(interrupted(), options.store.empty() ? Time{0} : kDrain);
  loop.bid_farewell("the coordinator was told to end");
  return ExitCode::done;
}

}  // namespace

void add_serve_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command = app.add_subcommand("serve", "Coordinate a farm: take jobs, hand out tiles");
  command->footer(
      "Runs until Ctrl-C or SIGTERM. Only loopback addresses can be bound: there are no keys yet.\n"
      "With --store, jobs and finished tiles outlive it, however it ends: start it again with the\n"
      "same folder and the jobs go on. Told to end, it waits up to 10 s for tiles being traced; a\n"
      "second signal ends it at once.\n"
      "Example, in three terminals:\n"
      "  tessera serve --store farm\n"
      "  tessera worker --connect tcp://127.0.0.1:7117 --threads 4\n"
      "  tessera submit bunny.obj && tessera fetch bunny --wait");
  command->add_option("--bind", options->endpoint, "Where to listen, tcp://HOST:PORT or ipc://PATH")
      ->type_name("ENDPOINT")
      ->capture_default_str();
  command->add_option("--http", options->http, "Web page and metrics (not yet)")->type_name("ADDR");
  command
      ->add_option("--store", options->store,
                   "Keep jobs and finished tiles in this folder [in memory]")
      ->type_name("DIR");
  command->callback([options, &action] { action = [options] { return serve(*options); }; });
}

}  // namespace tessera
