#include "cli/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/version.h"
#include "cli/say.h"

namespace tessera {
namespace {

constexpr char kDescription[] =
    "Tessera renders a scene tile by tile on many processes: the same picture, to the last bit,\n"
    "for any number of them.";
constexpr char kFooter[] =
    "Examples:\n"
    "  tessera render bunny.obj                           bunny.png, on every core of this "
    "machine\n"
    "  tessera render room.x3d -o room.exr --size 1920x1080 --spp 64\n"
    "  tessera info room.x3d                              what a scene holds, without rendering\n"
    "  tessera compare room.png room-before.png           do two pictures differ, and where\n"
    "\n"
    "'tessera COMMAND --help' tells all about a command.\n"
    "Exit codes: 0 done; 1 the scene or its data is wrong; 2 the command line is wrong;\n"
    "3 rendering failed (the picture, with holes marked, is still written); 4 interrupted.";

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

/// CLI11 would take an unknown command for a stray argument; its name is the better hint.
void check_command_name(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2) throw usage_error("no command; try 'tessera --help'");
  const std::string name = argv[1];
  if (name.starts_with("-")) return;
  const std::vector<std::string> names = command_names(app);
  for (const std::string& known : names) {
    if (name == known) return;
  }
  throw usage_error(
      fmt::format("'{}' is no command{}; try 'tessera --help'", name, suggestion(name, names)));
}

/// One clear line for what CLI11 found wrong.
Error usage_error_from(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = app.get_subcommands().empty() ? &app : app.get_subcommands().front();
  const std::string help =
      fmt::format("; try 'tessera {}--help'", command == &app ? "" : command->get_name() + " ");
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const std::vector<std::string> extras = command->remaining();
    const std::string extra = extras.empty() ? app.remaining(true).front() : extras.front();
    const std::string name = extra.substr(0, extra.find('='));
    if (!name.starts_with("-")) {
      return usage_error(fmt::format("'{}' is one argument too many{}", extra, help));
    }
    return usage_error(
        fmt::format("'{}' is no option{}{}", name, suggestion(name, option_names(*command)), help));
  }
  return usage_error(error.what() + help);
}

ExitCode parse_and_run(int argc, const char* const* argv) {
  CLI::App app{kDescription, "tessera"};
  app.set_version_flag("--version", fmt::format("tessera {}", kBuild), "Print the version");
  app.footer(kFooter);
  app.require_subcommand(1);
  app.get_formatter()->column_width(32);

  Action action;
  add_render_command(app, action);
  add_serve_command(app, action);
  add_worker_command(app, action);
  add_convert_command(app, action);
  add_info_command(app, action);
  add_compare_command(app, action);
  add_bench_command(app, action);
  try {
    check_command_name(app, argc, argv);
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {  // --help and --version
    app.exit(help);
    return ExitCode::done;
  } catch (const CLI::ParseError& error) {
    throw usage_error_from(app, error);
  }
  configure_logging("warn", "tessera");
  return action();
}

}  // namespace

ExitCode run_command_line(int argc, const char* const* argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const Error& error) {
    say(stderr, "tessera: {}\n", error.what());
    return error.code();
  } catch (const std::bad_alloc&) {
    say(stderr, "tessera: out of memory\n");
    return ExitCode::render_failed;
  } catch (const std::exception& error) {
    say(stderr, "tessera: {}\n", error.what());
    return ExitCode::render_failed;
  }
}

}  // namespace tessera
