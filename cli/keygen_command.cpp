#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <vector>

#include "base/error.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/enrol_key.h"
#include "cli/say.h"
#include "front/farm_connection.h"
#include "front/option_values.h"
#include "proto/transport/allow_list.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr char kCoordinator[] = "coordinator", kWorker[] = "worker", kDay[] = "24h";
constexpr int kMostTokens = 10'000;

struct KeygenOptions {
  std::string place, name, role;  ///< role: empty where none is named
  int tokens = 0;                 ///< how many to make; 0: a key
  std::string lifetime;           ///< of tokens; empty: a day
  std::string enrol;              ///< a file of tokens; empty: none
  FarmConnection connection;      ///< for `enrol`
};

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "tessera";
}

/// Where the secret key goes, and whose it is.
struct Target {
  fs::path file;
  std::string name;
};

/// A name that is not given is the file's, or this machine's where PLACE is a folder or
/// `is_of_host` is set.
Target target(const KeygenOptions& options, bool is_of_host) {
  Target target{options.place, options.name};
  const bool in_folder = fs::is_directory(target.file);
  if (target.name.empty() && (in_folder || is_of_host)) target.name = host_name();
  if (in_folder) target.file /= target.name + ".key";
  if (target.name.empty()) target.name = target.file.stem().string();
  check_key_name(target.name, options.name.empty() ? "keygen" : "--name");
  return target;
}

void check_new(const fs::path& path) {
  if (!fs::exists(path)) return;
  throw usage_error(
      fmt::format("keygen: '{}' is there already; expected a new file", path.string()));
}

fs::path public_file(const fs::path& secret) {
  const fs::path open = fs::path(secret).replace_extension(".pub");
  if (open == secret) throw usage_error("keygen: .pub is for the public key; expected NAME.key");
  return open;
}

ExitCode make_key(const KeygenOptions& options) {
  const bool own = options.role.empty() || options.role == kCoordinator;
  const Role role = own ? Role::any : parse_role(options.role, "--role");
  const auto [secret, name] = target(options, false);
  const fs::path open = public_file(secret);
  for (const fs::path& path : {secret, open}) check_new(path);
  const KeyPair keys = make_key_pair();
  const std::string line =
      own ? fmt::format("{} {} {}\n", key_text(keys.public_key), kCoordinator, name)
          : AllowList::line(keys.public_key, {role, name});
  write_new_file(secret, secret_key_file(keys, name), 0600);
  write_new_file(open, line, 0644);
  say("{}", line);
  return ExitCode::done;
}

ExitCode make_tokens(const KeygenOptions& options) {
  const Role role = parse_role(options.role.empty() ? kWorker : options.role, "--role");
  const WallTime until =
      wall_clock_now() +
      parse_duration("--for", options.lifetime.empty() ? kDay : options.lifetime);
  const auto [file, name] = target(options, false);
  check_new(file);
  std::vector<KeyPair> tokens;
  std::string lines;
  for (int i = 1; i <= options.tokens; ++i) {
    tokens.push_back(make_key_pair());
    const std::string own = options.tokens == 1 ? name : fmt::format("{}-{}", name, i);
    check_key_name(own, "--name");
    lines += AllowList::line(
        tokens.back().public_key,
        {.role = Role::enrol, .name = own, .key = {}, .grants = role, .until = until});
  }
  const std::string comment =
      fmt::format("Enrolment tokens: with each, one machine makes itself a {}'s key until {}.",
                  role_name(role), wall_time_text(until));
  write_new_file(file, secret_keys_file(tokens, comment), 0600);
  say("{}", lines);
  return ExitCode::done;
}

ExitCode enrol(const KeygenOptions& options) {
  const FarmConnection& farm = options.connection;
  if (farm.endpoint.empty() || farm.server_key.empty()) {
    throw usage_error(
        "--enrol: needs --connect and --server-key, the coordinator that takes up the key, beside "
        "it");
  }
  if (!options.role.empty()) {
    throw usage_error("--role: is the token's with --enrol; expected no --role");
  }
  const auto [file, name] = target(options, true);
  static_cast<void>(public_file(file));
  return enrol_key({file, name, options.enrol, farm.endpoint, farm.server_key});
}

ExitCode keygen(const KeygenOptions& options) {
  const FarmConnection& farm = options.connection;
  if (options.enrol.empty() && !(farm.endpoint.empty() && farm.server_key.empty())) {
    throw usage_error("--connect, --server-key: are for --enrol; expected that beside them");
  }
  if (options.tokens == 0 && !options.lifetime.empty()) {
    throw usage_error("--for: is for --tokens; expected that beside it");
  }
  if (options.tokens > 0 && !options.enrol.empty()) {
    throw usage_error("--tokens: makes what --enrol uses; expected one of them");
  }
  if (!options.enrol.empty()) return enrol(options);
  return options.tokens > 0 ? make_tokens(options) : make_key(options);
}

}  // namespace

void add_keygen_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<KeygenOptions>();
  CLI::App* command = app.add_subcommand("keygen", "Make a key for a farm over a network");
  command->footer(
      "Writes the secret key to FILE (or DIR/NAME.key), which only you can read and which stays "
      "on\n"
      "this machine, and the public one beside it, ending in .pub. That one line, which is "
      "printed\n"
      "too, is what a coordinator's list of keys holds. No file is ever replaced.\n"
      "Example, a farm of one worker:\n"
      "  tessera keygen coordinator.key\n"
      "  tessera keygen node1.key --role worker    >> farm.allow\n"
      "  tessera keygen alice.key --role submitter >> farm.allow\n"
      "  tessera serve --bind tcp://0.0.0.0:7117 --key coordinator.key --allow farm.allow --store "
      "farm\n"
      "  tessera worker --connect tcp://HOST:7117 --key node1.key --server-key coordinator.pub\n"
      "  tessera render bunny.obj --connect tcp://HOST:7117 --key alice.key \\\n"
      "    --server-key coordinator.pub\n"
      "Of many workers each makes its own key, and has the coordinator take it up by an enrolment\n"
      "token, which is of use once and until its time is over. FILE is there once that is done; "
      "to\n"
      "say it again does no harm:\n"
      "  tessera keygen rack.tokens --tokens 40 --for 2h >> farm.allow    (SIGHUP to the "
      "coordinator)\n"
      "  tessera keygen worker.key --enrol rack.tokens --connect tcp://HOST:7117 \\\n"
      "    --server-key coordinator.pub                                   (on each machine)\n"
      "Its exit code is 2 where no token is of use, 75 where the coordinator does not answer.");
  command->add_option("PLACE", options->place, "A new file for the secret key, or a folder")
      ->required()
      ->type_name("FILE|DIR");
  command
      ->add_option("--name", options->name,
                   "Whose key it is, for the log [FILE's name; with --enrol, this machine's]")
      ->type_name("NAME");
  command
      ->add_option("--role", options->role,
                   fmt::format("worker, submitter or viewer: that line is for the coordinator's "
                               "list; its own key is on none [{}; of tokens {}]",
                               kCoordinator, kWorker))
      ->type_name("ROLE");
  add_whole(*command, "--tokens", 1, kMostTokens,
            "Make so many enrolment tokens in FILE instead; their lines are for the list too",
            options->tokens);
  command
      ->add_option("--for", options->lifetime,
                   fmt::format("How long tokens are of use, such as 30m, 24h or 7d [{}]", kDay))
      ->type_name("DURATION");
  command
      ->add_option("--enrol", options->enrol,
                   "Have the coordinator take up the new key by one of the tokens in this file")
      ->type_name("FILE");
  command
      ->add_option("--connect", options->connection.endpoint,
                   "With --enrol: the coordinator, tcp://HOST:PORT")
      ->type_name("ENDPOINT");
  command
      ->add_option("--server-key", options->connection.server_key,
                   "With --enrol: the coordinator's public key, its .pub file or the 64 digits")
      ->type_name("FILE|KEY");
  command->callback([options, &action] { action = [options] { return keygen(*options); }; });
}

}  // namespace tessera
