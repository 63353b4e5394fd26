#include "python/gil.h"

#include <pthread.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

namespace tessera {
namespace {

/// Ends the process with that status, as exit() would, but destroys nothing that a thread uses.
void end_at_once(int status, void*) {
  std::fflush(nullptr);
  _exit(status);
}

}  // namespace

void UnlockedWork::is_waited_for_at_exit() {
  Py_AtExit([] {
    constexpr int kMostWaits = 1000;
    for (int i = 0; i < kMostWaits && count_ > 0; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    // What is registered last is called first, before static objects are destroyed.
    if (count_ > 0) on_exit(&end_at_once, nullptr);
  });
  // The threads of a parent do not live on in its child.
  pthread_atfork(nullptr, nullptr, [] { count_ = 0; });
}

}  // namespace tessera
