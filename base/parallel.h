#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "base/cancellation.h"
#include "base/signal_stack.h"

namespace tessera {

/// Calls work(i) for every i below `count`, on the calling thread and up to `threads` - 1 others,
/// fewer where no more can be had. Of several exceptions the one of the smallest i is thrown,
/// whatever the timing. Ends early by WorkCancelled where a Cancellation of the caller says so.
template <typename Work>
void for_each_parallel(size_t count, int threads, const Work& work) {
  std::atomic<size_t> next{0};
  std::mutex mutex;
  size_t failed = count;
  std::exception_ptr failure;
  const std::atomic<bool>* const cancelled = Cancellation::current();
  const auto run = [&] {
    for (size_t i = next++; i < count; i = next++) {
      try {
        Cancellation::check();
        work(i);
      } catch (const WorkCancelled&) {
        const std::lock_guard lock(mutex);
        failed = 0;
        failure = std::current_exception();
        next = count;  // none of the rest is looked at
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i >= failed) continue;
        failed = i;
        failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    const size_t wanted = std::min(count, static_cast<size_t>(std::max(threads, 1)));
    try {
      for (size_t i = 1; i < wanted; ++i) {
        helpers.emplace_back([&run, cancelled] {
          const SignalStack stack;
          const Cancellation cancellation(cancelled);
          run();
        });
      }
    } catch (const std::system_error&) {
      // Those that there are do it all.
    }
    run();
  }
  if (failure) std::rethrow_exception(failure);
}

/// Calls work(thread, i) for every i below `count`, on `threads` threads at most, numbered from 0:
/// for work that keeps something for each thread.
template <typename Work>
void for_each_of_thread(size_t count, int threads, const Work& work) {
  const size_t lanes = std::min(count, static_cast<size_t>(std::max(threads, 1)));
  for_each_parallel(lanes, threads, [&](size_t thread) {
    for (size_t i = thread; i < count; i += lanes) {
      Cancellation::check();
      work(thread, i);
    }
  });
}

/// Calls work(begin, end) for pieces of `length`, the last may be shorter, of 0 to `count`. Where
/// they are depends on nothing else, so that neither does what is made of each.
template <typename Work>
void for_each_piece_parallel(size_t count, size_t length, int threads, const Work& work) {
  for_each_parallel((count + length - 1) / length, threads,
                    [&](size_t i) { work(i * length, std::min(count, (i + 1) * length)); });
}

}  // namespace tessera
