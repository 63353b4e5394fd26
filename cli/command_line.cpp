#include "cli/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/log.h"
#include "base/version.h"
#include "cli/add_options.h"
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
    "  tessera submit room.x3d && tessera fetch room --wait   the same by a farm of 'tessera "
    "serve'\n"
    "\n"
    "'tessera help COMMAND' tells all about a command.\n"
    "Exit codes: 0 done; 1 the scene or its data is wrong; 2 the command line is wrong;\n"
    "3 rendering failed (the picture, with holes marked, is still written); 4 interrupted;\n"
    "75 not now, such as a port in use or a store on a full disk: try again.";

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return names;
}

/// Long ones that --help shows, without their dashes.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  }
  return names;
}

/// "; did you mean 'x'?", or the end of the sentence before.
std::string hint(const std::string& name, const std::vector<std::string>& names) {
  const std::string nearest = suggestion(name, names);
  return nearest.empty() ? "." : nearest;
}

/// The same for an option, which may be known by the name that another renderer has for it.
std::string option_hint(const std::string& typed, const CLI::App& command) {
  constexpr std::pair<std::string_view, std::string_view> kElsewhere[] = {
      {"samples", "spp"},     {"width", "size"},       {"height", "size"},   {"res", "size"},
      {"resolution", "size"}, {"nthreads", "threads"}, {"outfile", "output"}};
  const std::vector<std::string> names = option_names(command);
  const std::string name = typed.substr(std::min(typed.find_first_not_of('-'), typed.size()));
  std::string meant = name.size() > 1 ? nearest_name(name, names).value_or("") : "";
  for (const auto& [theirs, ours] : kElsewhere) {
    if (name == theirs && std::find(names.begin(), names.end(), ours) != names.end()) meant = ours;
  }
  return meant.empty() ? "." : fmt::format("; did you mean '--{}'?", meant);
}

/// CLI11 would take an unknown command, or kind of one, for a stray argument; its name is the
/// better hint.
void check_command_name(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2) throw usage_error("no command; try 'tessera --help'");
  const std::string name = argv[1];
  if (name.starts_with("-")) return;
  const auto commands =
      app.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  if (commands.empty()) {
    throw usage_error(fmt::format("'{}' is no command{} Try 'tessera --help'", name,
                                  hint(name, command_names(app))));
  }
  const std::vector<std::string> kinds = command_names(*commands.front());
  const std::string kind = argc > 2 ? argv[2] : "";
  if (kinds.empty() || kind.starts_with("-")) return;
  if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) return;
  throw usage_error(fmt::format("{}; expected one of {}{}",
                                kind.empty() ? fmt::format("{}: nothing after it", name)
                                             : fmt::format("{}: '{}'", name, kind),
                                fmt::join(kinds, ", "), suggestion(kind, kinds)));
}

/// Breaks descriptions into lines that fit beside the names.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(CLI::Formatter::make_option_desc(option), kHelpWidth - get_column_width());
  }

 private:
  static constexpr size_t kHelpWidth = 100;

  static std::string wrapped(std::string text, size_t width) {
    for (size_t start = 0; text.size() - start > width;) {
      const size_t space = text.rfind(' ', start + width);
      if (space == std::string::npos || space <= start) break;
      text[space] = '\n';
      start = space + 1;
    }
    return text;
  }
};

/// "help COMMAND" as "COMMAND --help", the way CLI11 knows it. Help about help is that about all.
std::vector<const char*> with_help_as_option(int argc, const char* const* argv) {
  std::vector<const char*> arguments(argv, argv + argc);
  if (argc < 2 || std::string_view(argv[1]) != "help") return arguments;
  while (arguments.size() > 1 && std::string_view(arguments[1]) == "help") {
    arguments.erase(arguments.begin() + 1);
  }
  arguments.push_back("--help");
  return arguments;
}

/// The arguments as CLI11 takes them: from the last to the first, without the program's name. Of
/// "--name=" it would take the next argument for the value; here its value is the empty text.
std::vector<std::string> reversed(const std::vector<const char*>& arguments) {
  std::vector<std::string> out;
  bool are_options = true;
  for (auto at = arguments.begin() + 1; at != arguments.end(); ++at) {
    const std::string_view argument = *at;
    are_options = are_options && argument != "--";
    const bool is_empty =
        are_options && argument.starts_with("--") && argument.find('=') + 1 == argument.size();
    out.emplace_back(argument.substr(0, argument.size() - (is_empty ? 1 : 0)));
    if (is_empty) out.emplace_back();
  }
  std::reverse(out.begin(), out.end());
  return out;
}

/// For an option without its value, or with several.
std::string wrong_count(const CLI::App& command, const CLI::ArgumentMismatch& error) {
  const std::string_view what = error.what();
  const std::string name(what.substr(0, what.find(':')));
  const CLI::Option* option = command.get_option_no_throw(name);
  if (option == nullptr) return error.what();
  if (option->count() > 1) return fmt::format("{}: given more than once", name);
  return fmt::format("{}: needs a value {}", name, option->get_type_name());
}

/// One clear line for what CLI11 found wrong.
Error usage_error_from(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  std::string of_command;
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    of_command += command->get_name() + " ";
  }
  const std::string help = fmt::format("; try 'tessera {}--help'", of_command);
  const std::vector<std::string> extras = command->remaining();
  // An unknown option comes before an argument that CLI11 misses, perhaps because of it.
  const bool has_unknown = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr &&
                           !extras.empty() && extras.front().starts_with("-");
  if (has_unknown || dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const std::string extra = extras.empty() ? app.remaining(true).front() : extras.front();
    if (extra == "--" && extras.size() > 1) {
      return usage_error(
          fmt::format("'{}' is one argument too many behind '--'; options go before "
                      "it{}",
                      extras[1], help));
    }
    const std::string name = extra.substr(0, extra.find('='));
    if (!name.starts_with("-")) {
      return usage_error(fmt::format("'{}' is one argument too many{}", extra, help));
    }
    return usage_error(fmt::format("'{}' is no option{} Try 'tessera {}--help'", name,
                                   option_hint(name, *command), of_command));
  }
  if (const auto* count = dynamic_cast<const CLI::ArgumentMismatch*>(&error)) {
    return usage_error(wrong_count(*command, *count) + help);
  }
  return usage_error(error.what() + help);
}

ExitCode parse_and_run(std::span<const AddCommand> commands, int argc, const char* const* argv) {
  CLI::App app{kDescription, "tessera"};
  app.set_version_flag("--version", fmt::format("tessera {}", kBuild), "Print the version");
  app.footer(kFooter);
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpFormatter>());
  app.get_formatter()->column_width(32);

  Action action;
  for (const AddCommand add : commands) add(app, action);
  check_texts(app);
  try {
    const std::vector<const char*> arguments = with_help_as_option(argc, argv);
    check_command_name(app, static_cast<int>(arguments.size()), arguments.data());
    app.parse(reversed(arguments));
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

ExitCode tell_current_error() {
  try {
    throw;
  } catch (const Error& error) {
    say_error(error.what());
    return error.code();
  } catch (const std::bad_alloc&) {
    say_error("out of memory");
  } catch (const std::system_error& error) {
    // What a thread that finds no room for its stack says.
    const bool is_full = error.code() == std::errc::resource_unavailable_try_again;
    say_error(is_full ? "out of memory: no further thread can be started" : error.what());
  } catch (const std::exception& error) {
    say_error(error.what());
  }
  return ExitCode::render_failed;
}

ExitCode run_command_line(std::span<const AddCommand> commands, int argc, const char* const* argv) {
  try {
    return parse_and_run(commands, argc, argv);
  } catch (const std::exception&) {
    return tell_current_error();
  }
}

}  // namespace tessera
