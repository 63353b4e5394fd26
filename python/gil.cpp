#include "python/gil.h"

#include <pthread.h>

#include <chrono>
#include <thread>

namespace tessera {

void UnlockedWork::is_waited_for_at_exit() {
  Py_AtExit([] {
    constexpr int kMostWaits = 1000;
    for (int i = 0; i < kMostWaits && count_ > 0; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  // The threads of a parent do not live on in its child.
  pthread_atfork(nullptr, nullptr, [] { count_ = 0; });
}

}  // namespace tessera
