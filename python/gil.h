#pragma once

#include <cxxabi.h>
#include <pybind11/eval.h>
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

/// Ends what is large without the GIL, which the caller must hold.
template <typename T>
void free_unlocked(T value) {
  const GilRelease unlocked;
  const T ends_first = std::move(value);
}

/// Lets threads that ask for the GIL have it, and signal handlers run, whose exceptions it throws.
///
/// It runs a function of Python that does nothing, before which the interpreter looks whether
/// anybody asks. A thread asks after it has waited for 5 ms; to release the GIL more often than
/// that would wake it each time, and have it wait anew.
inline void let_others_run() {
  static const pybind11::handle nothing = pybind11::eval("lambda: None").release();
  run_or_sleep([] { nothing(); });
}

/// For loops over Python's values, which need the GIL: called once a value, now and then calls
/// let_others_run(). What the loop looks at may have changed afterwards.
class GilPauses {
 public:
  void operator()() {
    constexpr uint32_t kValuesBetween = 256;
    if (++count_ % kValuesBetween == 0) let_others_run();
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
