#pragma once

#include <atomic>

namespace tessera {

/// From here on the first SIGINT or SIGTERM only sets the flag, so that work can end cleanly, and a
/// second one ends the process at once with exit code 4. Call once, before threads start.
void catch_interrupts();

/// Whether one has come. Safe from any thread.
const std::atomic<bool>& interrupted();

}  // namespace tessera
