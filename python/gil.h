#pragma once

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

#include <atomic>
#include <optional>

namespace tessera {

// Python ends a daemon thread that asks for the GIL while the interpreter is ending, by unwinding
// its stack. The destructors on the way would abort the process, or drop references without the
// GIL. Here such a thread sleeps until the process ends.

/// Returns what `call` does, which takes the GIL or runs code in Python.
template <typename Call>
decltype(auto) run_or_sleep(const Call& call) {
  try {
    return call();
  } catch (const abi::__forced_unwind&) {
    for (;;) pause();
  }
}

/// What a thread does without the GIL, for as long as this lives.
class UnlockedWork {
 public:
  UnlockedWork() { ++count_; }
  ~UnlockedWork() { --count_; }
  UnlockedWork(const UnlockedWork&) = delete;
  UnlockedWork& operator=(const UnlockedWork&) = delete;

  /// Has the end of the interpreter wait for such work of daemon threads, for some seconds: it may
  /// need static objects, which are destroyed next.
  static void is_waited_for_at_exit();

 private:
  static inline std::atomic<int> count_ = 0;
};

/// Releases the GIL, which the caller must hold, for as long as it lives.
class GilRelease {
 public:
  GilRelease() : state_(PyEval_SaveThread()) { work_.emplace(); }
  ~GilRelease() {
    work_.reset();
    run_or_sleep([this] { PyEval_RestoreThread(state_); });
  }
  GilRelease(const GilRelease&) = delete;
  GilRelease& operator=(const GilRelease&) = delete;

 private:
  PyThreadState* state_;
  std::optional<UnlockedWork> work_;
};

/// Holds the GIL for as long as it lives, on any thread, whether this held it before or not.
class GilAcquire {
 public:
  GilAcquire() : state_(run_or_sleep(PyGILState_Ensure)) {}
  ~GilAcquire() { PyGILState_Release(state_); }
  GilAcquire(const GilAcquire&) = delete;
  GilAcquire& operator=(const GilAcquire&) = delete;

 private:
  PyGILState_STATE state_;
};

}  // namespace tessera
