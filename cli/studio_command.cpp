#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/descriptors.h"
#include "base/file.h"
#include "base/json_log.h"
#include "base/log.h"
#include "base/process.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/log_format.h"
#include "cli/page_opener.h"
#include "cli/say.h"
#include "cli/server_security.h"
#include "coordinator/coordinator.h"
#include "coordinator/local_workers.h"
#include "coordinator/render_loop.h"
#include "front/farm_connection.h"
#include "front/render_options.h"
#include "proto/transport/zmq_transport.h"
#include "studio/files/studio_settings.h"
#include "studio/studio.h"
#include "web/log_ring.h"

namespace tessera {
namespace {

constexpr Time kBetweenPolls = std::chrono::milliseconds(5);
constexpr std::chrono::milliseconds kGrace{100};
/// Of the studio: it reads scenes, makes pictures, touches files and serves the page.
constexpr int kStudioThreads = 6;

/// Gives what is larger, films and pictures, back to the system as soon as it is freed. Without
/// this glibc raises its own threshold to the size of each film, and keeps films in the arena of
/// each thread: twice the memory after some edits.
constexpr int kReturnedBytes = 1 << 20;

struct StudioCommand {
  std::string path = ".";
  StudioOptions studio;
  std::optional<int> workers, threads;
  std::string endpoint;  ///< where workers of other machines come to; empty: they cannot
  SecurityOptions security;
  bool stays_closed = false;  ///< no browser is started
  bool json_log = false;
};

/// Sets what to open: a folder, or a file in its own folder.
void set_paths(StudioCommand& command) {
  const std::filesystem::path path = command.path;
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    command.studio.folder = path;
  } else if (std::filesystem::is_regular_file(path, error)) {
    command.studio.folder = path.has_parent_path() ? path.parent_path() : ".";
    command.studio.file = path.filename().string();
  } else {
    check_input_file(command.path, UINT64_MAX);  // throws, and tells why
  }
}

/// A whole number of the settings that the page keeps; nothing where they have none in the range.
std::optional<int> kept_number(const nlohmann::json& settings, const char* name, int least,
                               int most) {
  const auto at = settings.find(name);
  if (at == settings.end() || !at->is_number_integer()) return std::nullopt;
  const auto number = at->get<int64_t>();
  return least <= number && number <= most ? std::optional(static_cast<int>(number)) : std::nullopt;
}

/// Options of the command line take the place of what is kept.
LocalWorkerOptions worker_options(const StudioCommand& command) {
  const nlohmann::json kept = StudioSettings(StudioSettings::default_folder()).general();
  LocalWorkerOptions options;
  options.count =
      command.workers.value_or(kept_number(kept, "workers", 1, kMaxWorkers).value_or(core_count()));
  options.threads = command.threads.value_or(1);
  options.nice = kept_number(kept, "nice", 0, StudioSettings::kMostNice)
                     .value_or(StudioSettings::kWorkersNice);
  options.extra_arguments = {"--quiet"};
  return options;
}

/// Who may come to --bind, where that is given.
ServerSecurity joining_security(const StudioCommand& command) {
  const bool has_farm = !command.studio.farm.endpoint.empty();
  const bool has_server_key = !command.studio.farm.server_key.empty();
  if (has_server_key && !has_farm)
    throw usage_error("--server-key: is for the farm of --connect; expected that beside it");
  // One key names this studio to its own workers and to that farm.
  SecurityOptions security = command.security;
  if (has_server_key && security.allow.empty()) security.key.clear();
  if (!command.endpoint.empty()) return read_security(security);
  if (security.allow.empty() && (security.key.empty() || has_server_key)) return {};
  throw usage_error(fmt::format("{}: is for workers that join; expected --bind beside it",
                                security.allow.empty() ? "--key" : "--allow"));
}

/// The workers of this machine come by a socket of their own, without keys.
std::vector<ServerDoor> doors(const StudioCommand& command, const LocalWorkers& workers,
                              const ServerSecurity& security) {
  std::vector<ServerDoor> doors{{workers.endpoint()}};
  if (!command.endpoint.empty()) doors.push_back({command.endpoint, security});
  return doors;
}

/// Takes up the list of keys as it is now. A wrong one changes nothing.
void read_keys_again(RenderLoop& loop, const StudioCommand& command) {
  try {
    loop.set_allowed(read_allow_list(command.security.allow, "--allow"));
    spdlog::info("the list of keys has been read again");
  } catch (const Error& error) {
    spdlog::error("the list of keys stays as it was: {}", error.what());
  }
}

ExitCode run_studio(StudioCommand command) {
  mallopt(M_MMAP_THRESHOLD, kReturnedBytes);
  catch_interrupts();
  configure_logging("info", "studio");
  if (command.json_log) log_as_json();
  command.studio.log = LogRing::attach();
  keep_spare_descriptors();
  const int transports =
      1 + (command.endpoint.empty() ? 0 : 1) + (command.studio.farm.endpoint.empty() ? 0 : 1);
  check_room_for_threads(transports * kTransportThreads + kStudioThreads);
  set_paths(command);
  if (!command.studio.farm.server_key.empty()) command.studio.farm.key_file = command.security.key;
  const ServerSecurity security = joining_security(command);
  catch_hangups();
  const LocalWorkerOptions local = worker_options(command);
  command.studio.workers = local.count * local.threads;
  std::optional<HeldInterrupts> held(std::in_place);  // until the handler knows of the sockets
  LocalWorkers workers(local);
  CoordinatorOptions rules;
  rules.expected_workers = command.studio.workers;
  rules.worker_keys = security.allowed.count(Role::worker);
  RenderLoop loop(bind_servers(doors(command, workers, security)), rules);
  command.studio.worker_command = worker_command(loop.endpoints().back(), security);
  const std::filesystem::path socket = workers.endpoint().substr(std::string("ipc://").size());
  remove_when_interrupted(socket.parent_path().string(),
                          {socket.string(), socket.string() + ".bulk"});
  held.reset();
  loop.watch(&workers);
  {
    Studio studio(command.studio, [&loop] { loop.wake(); });
    loop.observe([&studio](Coordinator& coordinator, Time now) { studio.look(coordinator, now); },
                 kBetweenPolls);
    workers.start();
    const std::string page = studio.url();
    const std::string address =
        studio.token().empty() ? page : fmt::format("{}#token={}", page, studio.token());
    say("studio at {}\n", address);
    if (!command.endpoint.empty()) say("workers join at {}\n", loop.endpoints().back());
    flush_output();
    std::optional<PageOpener> opener;
    if (!command.stays_closed && isatty(STDOUT_FILENO)) opener.emplace(address);
    loop.serve(interrupted(), Time{0}, [&] {
      if (take_hangup() && security.keys) read_keys_again(loop, command);
    });
    loop.observe({}, Time::max());
  }
  if (command.endpoint.empty()) {
    loop.shut_down("the studio ends");
  } else {
    loop.bid_farewell("the studio ends");
  }
  workers.stop(kGrace);
  return ExitCode::done;
}

}  // namespace

void add_studio_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<StudioCommand>();
  CLI::App* command =
      app.add_subcommand("studio", "Build, look at and change a scene in the browser");
  command->footer(
      "Examples:\n"
      "  tessera studio                      the current folder\n"
      "  tessera studio scenes/room.tessera  its folder, with the file open\n"
      "It prints the page's address, with a token that the page needs, and opens it where there "
      "is\n"
      "a display. Ctrl-C ends it; unsaved text is offered again the next time.");
  command->add_option("PATH", options->path, "The file or folder to open [the current folder]")
      ->type_name("FILE|FOLDER");
  command
      ->add_option("--http", options->studio.address,
                   "Where to serve the page [127.0.0.1:7190, or the next free port]")
      ->type_name("ADDRESS:PORT");
  command
      ->add_option("--http-token", options->studio.token_file,
                   "Who may see the page, and who may edit: lines TOKEN ROLE NAME, ROLE being "
                   "viewer or submitter [a new token]")
      ->type_name("FILE");
  add_http_origin(*command, options->studio.public_address);
  command->add_flag("--no-open", options->stays_closed, "Only print the page's address");
  command->add_flag("--read-only", options->studio.is_read_only, "Write no file, and no draft");
  command
      ->add_option("--assets", options->studio.assets,
                   "The folder in which the files are that scenes name [the opened one]")
      ->type_name("DIR");
  add_whole(*command, "--workers", 1, kMaxWorkers, "Worker processes on this machine [one a core]",
            [options](int64_t typed) { options->workers = static_cast<int>(typed); });
  add_whole(*command, "--threads", 1, kMaxThreads, "Threads of each worker [1]",
            [options](int64_t typed) { options->threads = static_cast<int>(typed); });
  command
      ->add_option("--bind", options->endpoint,
                   "Where workers of other machines join, tcp://HOST:PORT [they cannot]")
      ->type_name("ENDPOINT");
  command
      ->add_option(
          "--key", options->security.key,
          "Our secret key, of 'tessera keygen': the coordinator's for --bind, a submitter's "
          "for --connect")
      ->type_name("FILE");
  command
      ->add_option("--allow", options->security.allow,
                   "For --bind: the keys that are let in, as for 'tessera serve'")
      ->type_name("FILE");
  command
      ->add_option("--connect", options->studio.farm.endpoint,
                   "The farm of a 'tessera serve' that traces full pictures and animations, "
                   "tcp://HOST:PORT or ipc://PATH [the workers of this studio]")
      ->type_name("ENDPOINT");
  command
      ->add_option("--server-key", options->studio.farm.server_key,
                   "For --connect: the farm's public key, its .pub file or the 64 digits")
      ->type_name("FILE|KEY");
  add_log_format(*command, options->json_log);
  command->callback([options, &action] { action = [options] { return run_studio(*options); }; });
}

}  // namespace tessera
