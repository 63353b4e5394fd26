#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "cli/command_line.h"

int main(int argc, char** argv) {
  // A reader that leaves early and a limit on file sizes are errors of that write, not our death.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  const tessera::ExitCode code = tessera::run_command_line(argc, argv);
  // Everything is written and every process has been waited for: taking the heap and some hundred
  // libraries down in order would only cost time.
  std::fflush(nullptr);
  std::_Exit(static_cast<int>(code));
}
