#pragma once

#include <functional>
#include <span>

#include "base/error.h"

namespace CLI {
class App;
}

namespace tessera {

/// What the chosen command does, run once the whole command line is known to be right.
using Action = std::function<ExitCode()>;

/// Adds a command to `app`; when that command is parsed it sets `action`.
using AddCommand = void (*)(CLI::App& app, Action& action);
void add_render_command(CLI::App& app, Action& action);
void add_serve_command(CLI::App& app, Action& action);
void add_worker_command(CLI::App& app, Action& action);
void add_studio_command(CLI::App& app, Action& action);
void add_keygen_command(CLI::App& app, Action& action);
void add_submit_command(CLI::App& app, Action& action);
/// status, pause, resume and cancel.
void add_job_commands(CLI::App& app, Action& action);
void add_fetch_command(CLI::App& app, Action& action);
void add_convert_command(CLI::App& app, Action& action);
void add_info_command(CLI::App& app, Action& action);
void add_compare_command(CLI::App& app, Action& action);
/// Hands all that follows `bench` to a program of its own, tessera-bench beside this one.
void add_bench_command(CLI::App& app, Action& action);

/// One line on standard error for the exception that is being handled, and the exit code that it
/// asks for: 3 unless it is an Error.
ExitCode tell_current_error();
/// Parses and runs; prints the error, if any, to standard error. Never throws.
ExitCode run_command_line(std::span<const AddCommand> commands, int argc, const char* const* argv);
/// The whole of a program of those commands, with its signals; returns what main() does.
int run_program(std::span<const AddCommand> commands, int argc, const char* const* argv);

}  // namespace tessera
