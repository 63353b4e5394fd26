#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "proto/wire/shared_memory.h"
#include "worker/blob_cache.h"

namespace tessera {

/// A blob to be looked for on this machine: at a place, or in the cache.
struct BlobLookup {
  Digest digest;
  uint64_t size = 0;
  std::optional<BlobPlace> place{};
};

struct BlobFound {
  Digest digest;
  BlobData blob;  ///< verified; null: it is not there
};

/// The thread that reads, verifies and writes blobs, so that whoever owns the socket never waits.
/// All functions are for the owner; `wake` is called by the thread when something was found, or
/// not.
class BlobLoader {
 public:
  /// `cache` may be null.
  BlobLoader(std::shared_ptr<BlobCache> cache, std::function<void()> wake);
  /// What is queued to be kept is kept before.
  ~BlobLoader();
  BlobLoader(const BlobLoader&) = delete;
  BlobLoader& operator=(const BlobLoader&) = delete;

  void look(const BlobLookup& lookup);
  void keep(const Digest& digest, BlobData blob);
  std::optional<BlobFound> take_found();

 private:
  struct Task {
    BlobLookup lookup;
    BlobData to_keep;  ///< null: to be looked for
  };
  void put(Task task);
  void work();
  BlobData find(const BlobLookup& lookup);

  std::shared_ptr<BlobCache> cache_;
  std::function<void()> wake_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  std::deque<BlobFound> found_;
  bool stop_ = false;
  std::thread thread_;  ///< from the first task on
};

}  // namespace tessera
