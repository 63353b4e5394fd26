#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "base/process_owned.h"
#include "front/frame_task.h"
#include "front/tracing_farm.h"

namespace tessera {

/// A farm with a thread of its own, on which it starts, runs its tasks one after the other and
/// ends: workers die with the thread that started them, so it must outlive every caller's. May be
/// used by any thread.
class FarmThread {
 public:
  using Start = std::function<std::unique_ptr<TracingFarm>()>;

  /// Returns at once; what goes wrong with `start` is what every task fails with.
  explicit FarmThread(Start start);
  /// As close(). In a process that was forked after it was made it does nothing: the thread is not
  /// there.
  ~FarmThread();
  FarmThread(const FarmThread&) = delete;
  FarmThread& operator=(const FarmThread&) = delete;

  /// Throws std::runtime_error once the farm is closed.
  void submit(std::shared_ptr<FrameTask> task);
  /// Cancels what runs and waits until workers, sockets and folders are gone. May be called again.
  void close();

 private:
  struct State {
    Start start;
    std::mutex mutex;
    std::condition_variable changed;
    TracingFarm* farm = nullptr;  ///< null: not started yet, or ended
    std::exception_ptr failure;   ///< of the farm, for its thread; null: none
    std::deque<std::shared_ptr<FrameTask>> waiting;
    std::shared_ptr<FrameTask> running;
    bool closed = false;
    std::thread thread;

    void run();
    /// Answers the farm's workers until there is one; null once it is closed.
    std::shared_ptr<FrameTask> next_task();
    /// Ends the wait for the next task.
    void wake();
  };

  ProcessOwned<State> state_;
};

}  // namespace tessera
