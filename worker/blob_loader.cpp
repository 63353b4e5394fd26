#include "worker/blob_loader.h"

#include <span>
#include <utility>

namespace tessera {

BlobLoader::BlobLoader(std::shared_ptr<BlobCache> cache, std::function<void()> wake)
    : cache_(std::move(cache)), wake_(std::move(wake)) {}

BlobLoader::~BlobLoader() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void BlobLoader::look(const BlobLookup& lookup) { put({lookup, nullptr}); }

void BlobLoader::keep(const Digest& digest, BlobData blob) {
  if (cache_) put({{digest, blob->size()}, std::move(blob)});
}

void BlobLoader::put(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  // Most workers share no machine with anybody and have no cache.
  if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
  changed_.notify_one();
}

std::optional<BlobFound> BlobLoader::take_found() {
  const std::lock_guard lock(mutex_);
  if (found_.empty()) return std::nullopt;
  BlobFound found = std::move(found_.front());
  found_.pop_front();
  return found;
}

BlobData BlobLoader::find(const BlobLookup& lookup) {
  if (!lookup.place) return cache_ ? cache_->find(lookup.digest, lookup.size) : nullptr;
  BlobData blob = map_shared_blob(*lookup.place, lookup.size);
  return blob && Digest::of(*blob) == lookup.digest ? blob : nullptr;
}

void BlobLoader::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || !tasks_.empty(); });
    if (tasks_.empty()) return;
    const Task task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    BlobFound found{task.lookup.digest, nullptr};
    if (task.to_keep) {
      cache_->keep(task.lookup.digest, *task.to_keep);
    } else {
      found.blob = find(task.lookup);
    }
    lock.lock();
    if (task.to_keep) continue;
    found_.push_back(std::move(found));
    lock.unlock();
    wake_();
    lock.lock();
  }
}

}  // namespace tessera
