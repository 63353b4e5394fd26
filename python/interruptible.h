#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <future>
#include <utility>

namespace tessera {

/// Runs `work(stop)` on a thread of its own without the GIL, and looks every 20 ms for signals: a
/// Python exception, such as KeyboardInterrupt, sets `stop`, waits for the work to end, and is
/// raised. Needs the GIL. Throws what `work` throws.
template <typename Work>
auto run_interruptibly(Work work) {
  std::atomic<bool> stop{false};
  auto running = std::async(std::launch::async, [&] { return work(stop); });
  for (;;) {
    bool is_done;
    {
      const pybind11::gil_scoped_release release;
      is_done = running.wait_for(std::chrono::milliseconds(20)) == std::future_status::ready;
    }
    if (is_done) return running.get();
    if (PyErr_CheckSignals() == 0) continue;
    pybind11::error_already_set interrupt;
    stop = true;
    {
      const pybind11::gil_scoped_release release;
      running.wait();
    }
    throw interrupt;
  }
}

}  // namespace tessera
