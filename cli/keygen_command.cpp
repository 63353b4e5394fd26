#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "base/error.h"
#include "cli/command_line.h"
#include "cli/say.h"
#include "proto/transport/allow_list.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr char kCoordinator[] = "coordinator";

struct KeygenOptions {
  std::string place, name;
  std::string role = kCoordinator;
};

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "tessera";
}

/// Writes a file that was not there, so that no key is ever lost to another.
void write_new(const fs::path& path, const std::string& text, mode_t mode) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  const auto fail = [&path](int cause) {
    throw usage_error(fmt::format(
        "keygen: cannot write '{}': {}", path.string(),
        cause == EEXIST ? "it is there already; expected a new file" : std::strerror(cause)));
  };
  if (file < 0) fail(errno);
  const ssize_t written = write(file, text.data(), text.size());
  const int cause = written < 0 ? errno : ENOSPC;
  const bool good = written == static_cast<ssize_t>(text.size()) && fsync(file) == 0;
  close(file);
  if (good) return;
  unlink(path.c_str());
  fail(cause);
}

ExitCode keygen(const KeygenOptions& options) {
  const bool own = options.role == kCoordinator;
  const Role role = own ? Role::any : parse_role(options.role, "--role");
  fs::path secret = options.place;
  std::string name = options.name;
  if (fs::is_directory(secret)) {
    if (name.empty()) name = host_name();
    secret /= name + ".key";
  }
  if (name.empty()) name = secret.stem().string();
  check_key_name(name, options.name.empty() ? "keygen" : "--name");
  fs::path open = secret;
  open.replace_extension(".pub");
  if (open == secret) throw usage_error("keygen: .pub is for the public key; expected NAME.key");
  for (const fs::path& path : {secret, open}) {
    if (!fs::exists(path)) continue;
    throw usage_error(
        fmt::format("keygen: '{}' is there already; expected a new file", path.string()));
  }
  const KeyPair keys = make_key_pair();
  const std::string line =
      own ? fmt::format("{} {} {}\n", key_text(keys.public_key), kCoordinator, name)
          : AllowList::line(keys.public_key, {role, name});
  write_new(secret, secret_key_file(keys, name), 0600);
  write_new(open, line, 0644);
  say("{}", line);
  return ExitCode::done;
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
      "  tessera serve --bind tcp://0.0.0.0:7117 --key coordinator.key --allow farm.allow\n"
      "  tessera worker --connect tcp://HOST:7117 --key node1.key --server-key coordinator.pub\n"
      "  tessera render bunny.obj --connect tcp://HOST:7117 --key alice.key \\\n"
      "    --server-key coordinator.pub");
  command->add_option("PLACE", options->place, "A new file for the secret key, or a folder")
      ->required()
      ->type_name("FILE|DIR");
  command
      ->add_option("--name", options->name,
                   "Whose key it is, for the log [FILE's name, or this machine's]")
      ->type_name("NAME");
  command
      ->add_option("--role", options->role,
                   fmt::format("worker, submitter or viewer: that line is for the coordinator's "
                               "list; its own key is on none [{}]",
                               kCoordinator))
      ->type_name("ROLE");
  command->callback([options, &action] { action = [options] { return keygen(*options); }; });
}

}  // namespace tessera
