#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

#include "base/cancellation.h"
#include "base/signal_stack.h"
#include "python/gil.h"

namespace tessera {

/// Work on a thread of its own, begun by the constructor.
template <typename Work>
class InterruptibleWork {
 public:
  explicit InterruptibleWork(Work work)
      : task_([this, work = std::move(work)]() mutable {
          const Work mine = std::move(work);  // ends with the work, also where that throws
          const SignalStack stack;
          const Cancellation cancellation(&cancelled_);
          return mine(static_cast<const std::atomic<bool>&>(cancelled_));
        }),
        result_(task_.get_future()) {}

  void run() { task_(); }
  /// Looks for Ctrl-C every 20 ms until the work has ended, or a signal handler raises: then
  /// returns what it raised, having told the work to end. The caller must hold the GIL.
  std::optional<pybind11::error_already_set> wait() {
    while (!ends_within(std::chrono::milliseconds(20))) {
      if (cancelled_ || PyErr_CheckSignals() == 0) continue;
      cancelled_ = true;
      return std::optional<pybind11::error_already_set>(std::in_place);
    }
    return std::nullopt;
  }
  auto result() { return result_.get(); }

 private:
  bool ends_within(std::chrono::milliseconds time) {
    const GilRelease release;
    const bool has_ended = result_.wait_for(time) == std::future_status::ready;
    if (_Py_IsFinalizing()) cancelled_ = true;
    return has_ended;
  }

  using Result = std::invoke_result_t<const Work&, const std::atomic<bool>&>;
  std::atomic<bool> cancelled_{false};
  std::packaged_task<Result()> task_;
  std::future<Result> result_;
};

/// Runs work(cancelled) without the GIL, which the caller must hold, on a thread of its own. What a
/// signal handler raises meanwhile is thrown once `work` has returned, which it is to do soon after
/// `cancelled` is set; for_each_parallel() in it does by itself. Returns or throws what `work`
/// does.
template <typename Work>
auto run_interruptibly(Work work) {
  InterruptibleWork running(std::move(work));
  std::jthread thread([&] {
    const UnlockedWork unlocked;
    running.run();
  });
  const auto interrupt = running.wait();
  {
    const GilRelease release;
    thread.join();
  }
  if (interrupt) throw *interrupt;
  return running.result();
}

/// Like run_interruptibly(), for work that owns all that it uses: what a signal handler raises is
/// thrown at once, while the abandoned work runs to its end and its result is dropped.
template <typename Work>
auto run_abandonably(Work work) {
  const auto running = std::make_shared<InterruptibleWork<Work>>(std::move(work));
  std::thread([running = running]() mutable {
    const UnlockedWork unlocked;
    running->run();
    running.reset();
  }).detach();
  if (const auto interrupt = running->wait()) throw *interrupt;
  return running->result();
}

/// Like run_abandonably(), for work that passes once over `bytes` bytes. Up to 16 MiB it runs on
/// this thread: such a pass, even one that hashes, ends within 0.1 s, when Python handles Ctrl-C.
template <typename Work>
auto run_unlocked(size_t bytes, Work work) {
  constexpr size_t kFew = size_t{16} << 20;
  if (bytes > kFew) return run_abandonably(std::move(work));
  const GilRelease unlocked;
  const std::atomic<bool> never{false};
  const Work mine = std::move(work);  // ends without the GIL, too
  return mine(never);
}

}  // namespace tessera
