#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "cli/command_line.h"

int main(int argc, char** argv) {
  // Who started us may ignore it, and then the kernel would not tell how our processes ended.
  std::signal(SIGCHLD, SIG_DFL);
  const tessera::ExitCode code = tessera::run_command_line(argc, argv);
  // Everything is written and every process has been waited for: taking the heap and some hundred
  // libraries down in order would only cost time.
  std::fflush(nullptr);
  std::_Exit(static_cast<int>(code));
}
