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
#include "python/gil.h"

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
    const UnlockedWork unlocked;
    const SignalStack stack;
    const Cancellation cancellation(&cancelled);
    return work(cancelled);
  });
  auto result = task.get_future();
  std::optional<py::error_already_set> interrupt;
  std::jthread worker(std::ref(task));
  const auto ends_within = [&](std::chrono::milliseconds time) {
    const GilRelease release;
    const bool has_ended = result.wait_for(time) == std::future_status::ready;
    if (_Py_IsFinalizing()) cancelled = true;
    return has_ended;
  };
  while (!ends_within(std::chrono::milliseconds(20))) {
    if (cancelled || PyErr_CheckSignals() == 0) continue;
    interrupt.emplace();
    cancelled = true;
  }
  {
    const GilRelease release;
    worker.join();
  }
  if (interrupt) throw *interrupt;
  return result.get();
}

}  // namespace tessera
