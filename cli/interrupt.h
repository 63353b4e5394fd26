#pragma once

#include <atomic>
#include <csignal>
#include <string>
#include <vector>

namespace tessera {

/// From here on the first SIGINT or SIGTERM only sets the flag, so that work can end cleanly, and a
/// second one ends the process at once with exit code 4. Call once, before threads start.
void catch_interrupts();

/// What a second interrupt removes on its way out: these files, then their folder. Paths longer
/// than any socket's are left alone.
void remove_when_interrupted(const std::string& folder, const std::vector<std::string>& files);

/// While it lives, interrupts of this thread wait: between making a file and telling the above of
/// it.
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
