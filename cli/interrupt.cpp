#include "cli/interrupt.h"

#include <unistd.h>

#include <csignal>

#include "base/error.h"

namespace tessera {
namespace {

std::atomic<bool> interrupt_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "it is set in a signal handler");

void on_interrupt(int) {
  if (interrupt_flag.exchange(true)) _exit(static_cast<int>(ExitCode::interrupted));
}

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A reader of our output that leaves early is an error of that write, not our death.
  std::signal(SIGPIPE, SIG_IGN);
}

const std::atomic<bool>& interrupted() { return interrupt_flag; }

}  // namespace tessera
