#pragma once

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <utility>

namespace tessera {

// Python ends a daemon thread that asks for the GIL while the interpreter is ending, by unwinding
// its stack. The destructors on the way would abort the process, or drop references without the
// GIL. Here such a thread sleeps until the process ends.

/// What a thread does without the GIL, for as long as this lives.
class UnlockedWork {
 public:
  UnlockedWork() { ++count_, ++own_count_; }
  ~UnlockedWork() { --count_, --own_count_; }
  UnlockedWork(const UnlockedWork&) = delete;
  UnlockedWork& operator=(const UnlockedWork&) = delete;

  /// Has the end of the interpreter wait for such work of daemon threads, for some seconds: it may
  /// need static objects, which are destroyed next. Where it goes on, they are not destroyed.
  static void is_waited_for_at_exit();
  /// For a thread that will do nothing more: none of its work is waited for any longer.
  static void forget_that_of_this_thread() { count_ -= std::exchange(own_count_, 0); }

 private:
  static inline std::atomic<int> count_ = 0;
  static inline thread_local int own_count_ = 0;
};

/// Returns what `call` does, which takes the GIL or runs code in Python.
template <typename Call>
decltype(auto) run_or_sleep(const Call& call) {
  try {
    return call();
  } catch (const abi::__forced_unwind&) {
    UnlockedWork::forget_that_of_this_thread();
    for (;;) pause();
  }
}

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

/// For loops over Python's values, which need the GIL: called once a value, lets other threads and
/// Ctrl-C in now and then, as to do so takes longer than a value. What the loop looks at may have
/// changed afterwards. Throws what a signal handler raises.
class GilPauses {
 public:
  void operator()() {
    constexpr uint32_t kValuesBetween = 1024;
    if (++count_ % kValuesBetween != 0) return;
    { const GilRelease others_run; }
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }

 private:
  uint32_t count_ = 0;
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
