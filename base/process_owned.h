#pragma once

#include <unistd.h>

#include <memory>
#include <utility>

namespace tessera {

/// Owns something that has threads. They are not there in a forked child, where destroying it would
/// wait for them forever: there it is never destroyed.
template <typename T>
class ProcessOwned {
 public:
  explicit ProcessOwned(std::unique_ptr<T> owned) : owned_(std::move(owned)) {}
  ~ProcessOwned() {
    if (!is_ours()) static_cast<void>(owned_.release());
  }
  ProcessOwned(const ProcessOwned&) = delete;
  ProcessOwned& operator=(const ProcessOwned&) = delete;

  /// Whether this is the process that made it.
  bool is_ours() const { return getpid() == process_; }
  T* get() const { return owned_.get(); }
  T& operator*() const { return *owned_; }
  T* operator->() const { return owned_.get(); }

 private:
  const pid_t process_ = getpid();
  std::unique_ptr<T> owned_;
};

}  // namespace tessera
