#include <execinfo.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <system_error>

#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/say.h"

namespace tessera {
namespace {

/// A thread that runs out of memory ends the process as an error; all else is a bug, and aborts.
void on_uncaught() {
  if (const auto error = std::current_exception()) {
    try {
      std::rethrow_exception(error);
    } catch (const std::bad_alloc&) {
      end_at_once(tell_current_error());
    } catch (const std::system_error&) {
      end_at_once(tell_current_error());
    } catch (...) {
    }
  }
  std::abort();
}

/// Exceptions that come through frames of the C library (std::call_once) need what unwinds them,
/// which it loads by then only, and aborts where memory is short.
void load_unwinder() {
  void* frame;
  static_cast<void>(backtrace(&frame, 1));
}

}  // namespace

int run_program(std::span<const AddCommand> commands, int argc, const char* const* argv) {
  end_at_interrupts();
  std::set_terminate(on_uncaught);
  load_unwinder();
  // Who started us may ignore it, and then the kernel would not tell how our processes ended.
  std::signal(SIGCHLD, SIG_DFL);
  // A reader that leaves early and a limit on file sizes are errors of that write, not our death.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  ExitCode code = run_command_line(commands, argc, argv);
  // A reader that has seen enough is no failure; a disk that is full is one.
  const int error = flush_output();
  if (error != 0 && error != EPIPE && error != EBADF && code == ExitCode::done) {
    std::fprintf(stderr, "tessera: standard output cannot be written: %s\n", std::strerror(error));
    code = ExitCode::render_failed;
  }
  return static_cast<int>(code);
}

}  // namespace tessera
