#pragma once

#include <atomic>
#include <csignal>
#include <string>
#include <vector>

#include "base/error.h"

namespace tessera {

/// From here on SIGINT, SIGTERM and, unless it is ignored by now, SIGHUP end the process at once,
/// with exit code 4 and without a half-written file; one that was held back until now does so here.
/// To be called first of all.
void end_at_interrupts();
/// From here on the first of them only sets the flag, so that work can end cleanly; a later one but
/// SIGHUP ends the process as before. Call once, before threads start.
void catch_interrupts();

/// Ends the process as an interrupt would, but with that exit code.
[[noreturn]] void end_at_once(ExitCode code);

/// What the last interrupt removes on its way out: these files, then their folder. Paths longer
/// than any socket's are left alone.
void remove_when_interrupted(const std::string& folder, const std::vector<std::string>& files);

/// While it lives, interrupts of this thread wait: between making a file and telling the above of
/// it, and while another program takes this one's place, until that one's end_at_interrupts().
class HeldInterrupts {
 public:
  HeldInterrupts();
  ~HeldInterrupts();
  HeldInterrupts(const HeldInterrupts&) = delete;
  HeldInterrupts& operator=(const HeldInterrupts&) = delete;

 private:
  sigset_t before_{};
};

/// Whether one has come. Safe from any thread.
const std::atomic<bool>& interrupted();

/// From here on SIGHUP does not end the process but is told by take_hangup().
void catch_hangups();
/// Whether one has come since the last call.
bool take_hangup();

}  // namespace tessera
