#include "cli/interrupt.h"

#include <unistd.h>

#include <array>
#include <csignal>

#include "base/file.h"

namespace tessera {
namespace {

std::atomic<bool> interrupt_flag{false}, hangup_flag{false};
std::atomic<bool> flag_is_heeded{false};
static_assert(std::atomic<bool>::is_always_lock_free, "they are used in a signal handler");

/// The leftovers, in memory that a signal handler may read: written once, then published by count.
constexpr size_t kLongestPath = 128;
std::array<std::array<char, kLongestPath>, 4> leftovers;
std::atomic<size_t> leftover_count{0};

constexpr std::array kInterrupts{SIGINT, SIGTERM, SIGHUP};

sigset_t all_interrupts() {
  sigset_t all;
  sigemptyset(&all);
  for (const int signal : kInterrupts) sigaddset(&all, signal);
  return all;
}

void on_interrupt(int signal) {
  const bool is_first = !interrupt_flag.exchange(true);
  // Of a terminal that closes both the kernel and the shell may tell.
  if (flag_is_heeded && (is_first || signal == SIGHUP)) return;
  end_at_once(ExitCode::interrupted);
}

}  // namespace

void end_at_once(ExitCode code) {
  remove_unfinished_output();
  const size_t count = leftover_count;
  for (size_t i = 0; i < count; ++i) {
    if (unlink(leftovers[i].data()) != 0) rmdir(leftovers[i].data());
  }
  _exit(static_cast<int>(code));
}

void end_at_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  sigemptyset(&action.sa_mask);
  for (const int signal : kInterrupts) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    const bool outlives_terminal = signal == SIGHUP && before.sa_handler == SIG_IGN;  // by nohup
    if (!outlives_terminal) sigaction(signal, &action, nullptr);
  }
  const sigset_t held = all_interrupts();
  pthread_sigmask(SIG_UNBLOCK, &held, nullptr);
}

void catch_interrupts() { flag_is_heeded = true; }

void remove_when_interrupted(const std::string& folder, const std::vector<std::string>& files) {
  size_t count = 0;
  const auto keep = [&count](const std::string& path) {
    if (path.size() < kLongestPath && count < leftovers.size()) {
      path.copy(leftovers[count++].data(), kLongestPath - 1);
    }
  };
  for (const std::string& file : files) keep(file);
  keep(folder);
  leftover_count = count;
}

HeldInterrupts::HeldInterrupts() {
  const sigset_t held = all_interrupts();
  pthread_sigmask(SIG_BLOCK, &held, &before_);
}

HeldInterrupts::~HeldInterrupts() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

const std::atomic<bool>& interrupted() { return interrupt_flag; }

void catch_hangups() {
  struct sigaction action {};
  action.sa_handler = [](int) { hangup_flag = true; };
  sigemptyset(&action.sa_mask);
  sigaction(SIGHUP, &action, nullptr);
}

bool take_hangup() { return hangup_flag.exchange(false); }

}  // namespace tessera
