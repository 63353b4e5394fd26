#include "scenes/import/read_cache.h"

#include <algorithm>

namespace tessera {

std::shared_ptr<const void> ReadCache::find(const std::string& key) {
  const auto at = entries_.find(key);
  if (at == entries_.end() || !are_unchanged(at->second.states)) {
    ++misses_;
    return nullptr;
  }
  ++hits_;
  Entry& entry = at->second;
  entry.used = ++uses_;
  // What is made of it depends on the same files.
  InputScope::note(entry.states);
  return entry.value;
}

void ReadCache::keep(const std::string& key, std::shared_ptr<const void> value, uint64_t bytes,
                     InputStates states) {
  if (const auto old = entries_.find(key); old != entries_.end()) {
    bytes_ -= old->second.bytes;
    entries_.erase(old);
  }
  if (bytes > most_bytes_) return;
  while (bytes_ + bytes > most_bytes_) {
    const auto oldest =
        std::ranges::min_element(entries_, {}, [](const auto& entry) { return entry.second.used; });
    bytes_ -= oldest->second.bytes;
    entries_.erase(oldest);
  }
  bytes_ += bytes;
  entries_[key] = {std::move(value), bytes, std::move(states), ++uses_};
}

}  // namespace tessera
