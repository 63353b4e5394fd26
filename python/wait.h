#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "base/signal_stack.h"

namespace tessera {

/// Runs work(cancelled) without the GIL, which the caller must hold, on a thread of its own, and
/// looks for Ctrl-C every 20 ms meanwhile. What a signal handler raises is thrown once `work` has
/// returned, which it is to do soon after `cancelled` is set. What `work` throws is thrown here.
template <typename Work>
void run_interruptibly(const Work& work) {
  namespace py = pybind11;
  std::atomic<bool> cancelled{false};
  std::mutex mutex;
  std::condition_variable ended;
  bool is_done = false;
  std::exception_ptr failure;
  std::optional<py::error_already_set> interrupt;
  {
    const py::gil_scoped_release release;
    const std::jthread worker([&] {
      const SignalStack stack;
      try {
        work(cancelled);
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      is_done = true;
      ended.notify_one();
    });
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, std::chrono::milliseconds(20), [&] { return is_done; })) {
      if (cancelled) continue;
      lock.unlock();
      {
        const py::gil_scoped_acquire acquire;
        if (PyErr_CheckSignals() != 0) {
          interrupt.emplace();
          cancelled = true;
        }
      }
      lock.lock();
    }
  }
  if (interrupt) throw *interrupt;
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tessera
