#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "base/program_folder.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"

namespace tessera {
namespace {

/// Returns only by an exception.
ExitCode become_tessera_bench(std::vector<std::string> arguments) {
  const std::string program = (program_folder() / "tessera-bench").string();
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const HeldInterrupts until_it_catches_them;
  execv(program.c_str(), pointers.data());
  throw render_error(fmt::format("{}: {}", program, std::strerror(errno)));
}

}  // namespace

void add_bench_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("bench", "Measure this program on this machine");
  command->prefix_command();
  command->set_help_flag();
  command->callback([command, &action] {
    std::vector<std::string> arguments{"tessera", "bench"};
    for (const std::string& argument : command->remaining()) arguments.push_back(argument);
    action = [arguments] { return become_tessera_bench(arguments); };
  });
}

}  // namespace tessera
