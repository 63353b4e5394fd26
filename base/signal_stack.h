#pragma once

#include <signal.h>

#include <cstddef>

namespace tessera {

/// Memory on which the handlers of signals that ask for it (SA_ONSTACK) run in the thread that made
/// this: they run even where that thread's own stack has overflowed. It is meant to be the first
/// local variable of a thread, at the far end of the stack from where that overflows.
class SignalStack {
 public:
  SignalStack() {
    stack_t own{};
    own.ss_sp = memory_;
    own.ss_size = sizeof memory_;
    sigaltstack(&own, &before_);
  }
  ~SignalStack() { sigaltstack(&before_, nullptr); }
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  /// What the kernel stores there is the larger the wider the vectors are: 11 KiB with AMX. Memory
  /// that is never written to takes none.
  static constexpr size_t kBytes = size_t{32} << 10;

  stack_t before_{};
  alignas(64) std::byte memory_[kBytes];
};

}  // namespace tessera
