#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <optional>
#include <thread>

#include "base/cancellation.h"
#include "base/signal_stack.h"

namespace tessera {

/// Runs work(cancelled) without the GIL, which the caller must hold, on a thread of its own, and
/// looks for Ctrl-C every 20 ms meanwhile. What a signal handler raises is thrown once `work` has
/// returned, which it is to do soon after `cancelled` is set; for_each_parallel() in it does by
/// itself. Returns or throws what `work` does.
template <typename Work>
auto run_interruptibly(const Work& work) {
  namespace py = pybind11;
  std::atomic<bool> cancelled{false};
  std::packaged_task task([&] {
    const SignalStack stack;
    const Cancellation cancellation(&cancelled);
    return work(cancelled);
  });
  auto result = task.get_future();
  std::optional<py::error_already_set> interrupt;
  {
    const py::gil_scoped_release release;
    const std::jthread worker(std::ref(task));
    while (result.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
      if (cancelled) continue;
      const py::gil_scoped_acquire acquire;
      if (PyErr_CheckSignals() != 0) {
        interrupt.emplace();
        cancelled = true;
      }
    }
  }
  if (interrupt) throw *interrupt;
  return result.get();
}

}  // namespace tessera
