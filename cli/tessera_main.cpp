#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "cli/command_line.h"

int main(int argc, char** argv) {
  // Who started us may ignore it, and then the kernel would not tell how our processes ended.
  std::signal(SIGCHLD, SIG_DFL);
  // A reader that leaves early and a limit on file sizes are errors of that write, not our death.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  tessera::ExitCode code = tessera::run_command_line(argc, argv);
  // A reader that has seen enough is no failure; a disk that is full is one.
  if (std::fflush(stdout) != 0 && errno != EPIPE && errno != EBADF &&
      code == tessera::ExitCode::done) {
    std::fprintf(stderr, "tessera: standard output cannot be written: %s\n", std::strerror(errno));
    code = tessera::ExitCode::render_failed;
  }
  return static_cast<int>(code);
}
