#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "base/digest.h"
#include "base/shared_arena.h"

namespace tessera {

/// Things that this process has made and somebody of it still has: who needs an equal one need not
/// make it again. Keeps none alive. Thread-safe.
class WeakCache {
 public:
  /// `key` is of all that the thing is made from, and of its type T. Null: nobody has it any more.
  template <typename T>
  std::shared_ptr<const T> find(const Digest& key) const {
    const std::lock_guard lock(mutex_);
    const auto it = things_.find(key);
    return it == things_.end() ? nullptr : std::static_pointer_cast<const T>(it->second.lock());
  }
  void note(const Digest& key, const std::shared_ptr<const void>& thing) {
    const std::lock_guard lock(mutex_);
    std::erase_if(things_, [](const auto& entry) { return entry.second.expired(); });
    things_[key] = thing;
  }

 private:
  mutable std::mutex mutex_;
  std::map<Digest, std::weak_ptr<const void>> things_;
};

/// Where what takes long to make is shared; both must outlive all that is made. Null: nowhere.
struct Sharing {
  const SharedArena* arena = nullptr;  ///< with other processes of this machine
  WeakCache* live = nullptr;           ///< within this one
};

}  // namespace tessera
