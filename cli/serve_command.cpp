#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/descriptors.h"
#include "base/file.h"
#include "base/json_log.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/process.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/log_format.h"
#include "cli/say.h"
#include "cli/server_security.h"
#include "cli/service_manager.h"
#include "coordinator/key_registry.h"
#include "coordinator/render_loop.h"
#include "coordinator/store/sqlite_job_store.h"
#include "coordinator/tev/tev_viewer.h"
#include "coordinator/web/farm_page.h"
#include "front/farm_connection.h"
#include "front/option_values.h"
#include "proto/transport/zmq_transport.h"

namespace tessera {
namespace {

/// How long tiles that are being traced may take, once it is told to end.
constexpr Time kDrain = std::chrono::seconds(10);
/// At the coordinator, by who shows it.
constexpr Time kBetweenLooks = std::chrono::milliseconds(20);

struct ServeOptions {
  std::string endpoint = kDefaultEndpoint;
  SecurityOptions security;
  std::string enrolled;
  std::string http, http_token, tev, store;
  std::optional<PublicAddress> public_address;  ///< of a proxy before the page
  bool json_log = false;
  double verify = 0;
};

/// The keys of --allow, and those that machines enrolled before. Those of later ones are kept in
/// --enrolled, or in the store's folder, which must be locked before any is.
KeyRegistry open_registry(const ServeOptions& options, AllowList listed) {
  std::string file = options.enrolled;
  if (!file.empty()) check_output_file(file, "--enrolled");
  if (file.empty() && !options.store.empty()) {
    file = (std::filesystem::path(options.store) / "enrolled.allow").string();
  }
  if (file.empty()) return KeyRegistry(std::move(listed));
  std::error_code unknown;
  const bool is_new = !std::filesystem::exists(file, unknown) && !unknown;
  return KeyRegistry(
      std::move(listed), [file](const std::string& text) { write_output_file(file, text); },
      is_new ? "" : read_allow_text(file, "--enrolled"), file);
}

/// Takes up the list of keys as it is now. A wrong one changes nothing.
void read_keys_again(RenderLoop& loop, KeyRegistry& keys, const ServeOptions& options) {
  try {
    keys.set_listed(read_allow_list(options.security.allow, "--allow"));
    spdlog::info("the list of keys has been read again: {}", counted(keys.keys().size(), "key"));
    loop.set_allowed(keys.keys());
  } catch (const Error& error) {
    spdlog::error("the list of keys stays as it was: {}", error.what());
  }
}

/// The same of the page's tokens.
void read_tokens_again(FarmPage& page) {
  try {
    page.read_tokens_again();
    spdlog::info("the page's tokens have been read again");
  } catch (const Error& error) {
    spdlog::error("the page's tokens stay as they were: {}", error.what());
  }
}

CoordinatorOptions coordinator_options(const ServeOptions& options) {
  CoordinatorOptions result;
  result.verify = options.verify;
  return result;
}

FarmPage::Options page_options(const ServeOptions& options) {
  return {.address = options.http,
          .token_file = options.http_token,
          .public_address = options.public_address,
          .has_keys = !options.security.key.empty(),
          .stopping = &interrupted()};
}

ExitCode serve(const ServeOptions& options) {
  configure_logging("info", "serve");
  if (options.json_log) log_as_json();
  keep_spare_descriptors();
  check_room_for_threads(kTransportThreads + (options.http.empty() ? 0 : 1) +
                         (options.tev.empty() ? 0 : 1));
  ServerSecurity security = read_security(options.security);
  if (!security.keys && !options.enrolled.empty()) {
    throw usage_error("--enrolled: needs --allow, which holds the enrolment tokens, beside it");
  }
  if (options.http.empty() && !options.http_token.empty()) {
    throw usage_error("--http-token: needs --http, the page's address, beside it");
  }
  if (options.http.empty() && options.public_address) {
    throw usage_error("--http-origin: needs --http, the page's address here, beside it");
  }
  std::optional<FarmPage> page;
  if (!options.http.empty()) page.emplace(page_options(options));
  std::optional<TevViewer> tev;
  if (!options.tev.empty()) tev.emplace(options.tev);
  const bool has_keys = security.keys.has_value();
  const AllowList listed = security.allowed;
  const auto registry = [&] {
    return has_keys ? open_registry(options, listed) : KeyRegistry(AllowList());
  };
  // An address that is taken leaves no store behind. Enrolled machines that come before the store
  // is open are let in by what is kept of them now.
  security.allowed = registry().keys();
  auto server = bind_server(options.endpoint, std::move(security));
  // Until here, where a name server may be silent, one ends it at once.
  catch_interrupts();
  std::shared_ptr<JobStore> store;
  if (!options.store.empty()) store = std::make_shared<SqliteJobStore>(options.store);
  KeyRegistry keys = registry();
  catch_hangups();
  RenderLoop loop(std::move(server), coordinator_options(options), std::move(store));
  loop.enrol_into(&keys);
  loop.set_allowed(keys.keys());
  say("serving at {}\n", loop.endpoint());
  if (page) say("page at {}\n", page->url());
  loop.observe(
      [&](Coordinator& coordinator, Time now) {
        if (page) page->look(coordinator, now);
        if (tev) tev->look(coordinator, now);
      },
      kBetweenLooks);
  flush_output();
  notify_service_manager("READY=1");
  // What is traced while no store keeps it is lost in any case.
  loop.serve(interrupted(), options.store.empty() ? Time{0} : kDrain, [&] {
    if (!take_hangup()) return;
    if (!has_keys && options.http_token.empty()) {
      spdlog::info("SIGHUP: there is neither --allow nor --http-token to read again");
    }
    if (has_keys) read_keys_again(loop, keys, options);
    if (!options.http_token.empty()) read_tokens_again(*page);
  });
  notify_service_manager("STOPPING=1");
  loop.bid_farewell("the coordinator was told to end");
  return ExitCode::done;
}

}  // namespace

void add_serve_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command = app.add_subcommand("serve", "Coordinate a farm: take jobs, hand out tiles");
  command->footer(
      "Runs until Ctrl-C or SIGTERM. Without keys, only this machine is let in; 'tessera help\n"
      "keygen' tells how to have some. SIGHUP reads the list of keys and the page's tokens again,\n"
      "and whoever is not listed any more is shut out.\n"
      "With --store, jobs and finished tiles outlive it, however it ends: start it again with the\n"
      "same folder and the jobs go on. Told to end, it waits up to 10 s for tiles being traced; a\n"
      "second signal ends it at once.\n"
      "Example, in three terminals:\n"
      "  tessera serve --store farm\n"
      "  tessera worker --connect tcp://127.0.0.1:7117 --threads 4\n"
      "  tessera submit bunny.obj && tessera fetch bunny --wait");
  command
      ->add_option(
          "--bind", options->endpoint,
          fmt::format("Where to listen, tcp://HOST:PORT or ipc://PATH [{}]", options->endpoint))
      ->type_name("ENDPOINT");
  command
      ->add_option("--key", options->security.key,
                   "The coordinator's secret key, of 'tessera keygen'")
      ->type_name("FILE");
  command
      ->add_option(
          "--allow", options->security.allow,
          "The keys that are let in: lines KEY ROLE NAME, as 'tessera keygen' prints them; "
          "KEY revoked NAME shuts out one that was enrolled")
      ->type_name("FILE");
  command
      ->add_option(
          "--enrolled", options->enrolled,
          "Where keys are kept that machines enrol by tokens of --allow [enrolled.allow in "
          "the folder of --store]")
      ->type_name("FILE");
  command->add_flag("--insecure", options->security.insecure,
                    "Let in whoever can reach the endpoint, from other machines too, without keys");
  command
      ->add_option("--http", options->http,
                   "Serve the web page, /metrics and /api/v1 there, such as 127.0.0.1:8080")
      ->type_name("ADDRESS:PORT");
  command
      ->add_option("--http-token", options->http_token,
                   "Who may see the page: lines TOKEN ROLE NAME, ROLE being viewer or submitter")
      ->type_name("FILE");
  add_http_origin(*command, options->public_address);
  command->add_option("--tev", options->tev, "Show what is traced in the image viewer tev there")
      ->type_name("HOST:PORT");
  add_log_format(*command, options->json_log);
  command
      ->add_option("--store", options->store,
                   "Keep jobs and finished tiles in this folder [in memory]")
      ->type_name("DIR");
  command
      ->add_option_function<std::string>(
          "--verify",
          [options](const std::string& text) { options->verify = parse_share("--verify", text); },
          "The share of tiles that a second worker traces too, such as 1%; where two differ a "
          "third "
          "judges, and who was wrong is set aside [0%]")
      ->type_name("SHARE");
  command->callback([options, &action] { action = [options] { return serve(*options); }; });
}

}  // namespace tessera
