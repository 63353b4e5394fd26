#pragma once

#include <atomic>

namespace tessera {

/// What work throws that was asked to end before it is done.
struct WorkCancelled {};

/// While it lives, what this thread gives to for_each_parallel() ends by WorkCancelled soon after
/// `flag` is set, also inside of what is given to it.
class Cancellation {
 public:
  explicit Cancellation(const std::atomic<bool>* flag) : before_(current_) { current_ = flag; }
  ~Cancellation() { current_ = before_; }
  Cancellation(const Cancellation&) = delete;
  Cancellation& operator=(const Cancellation&) = delete;

  /// The flag of this thread; null: none.
  static const std::atomic<bool>* current() { return current_; }
  /// Throws WorkCancelled where the flag of this thread is set: for long work on one thread.
  static void check() {
    if (current_ && current_->load(std::memory_order_relaxed)) throw WorkCancelled{};
  }

 private:
  static inline thread_local const std::atomic<bool>* current_ = nullptr;
  const std::atomic<bool>* before_;
};

}  // namespace tessera
