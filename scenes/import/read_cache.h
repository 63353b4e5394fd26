#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "base/input_scope.h"

namespace tessera {

/// Keeps what files were read as while none of them changes, so that a scene with one file that has
/// changed is read anew without the others. What depends on a file, and on which, is found out by
/// InputScope. Bounded: what was used longest ago goes first. Used by one thread at a time, and
/// with the same decoders of pictures always.
class ReadCache {
 public:
  explicit ReadCache(uint64_t most_bytes) : most_bytes_(most_bytes) {}
  ReadCache(const ReadCache&) = delete;
  ReadCache& operator=(const ReadCache&) = delete;

  /// What was made under `key` before, if all that was looked at then is unchanged; else what
  /// `make` returns now; `bytes_of` tells how much memory that takes. `key` names the type T
  /// and all that it depends on beside files. What `make` throws is passed on and not kept.
  template <typename T, typename Make, typename BytesOf>
  std::shared_ptr<const T> get(const std::string& key, const Make& make, const BytesOf& bytes_of) {
    if (auto known = find(key)) return std::static_pointer_cast<const T>(std::move(known));
    InputStates states;
    std::shared_ptr<const T> made;
    {
      const InputScope scope(nullptr, &states);
      made = std::make_shared<const T>(make());
    }
    keep(key, made, bytes_of(*made), std::move(states));
    return made;
  }

  uint64_t bytes() const { return bytes_; }
  /// How often something was found, and made.
  uint64_t hits() const { return hits_; }
  uint64_t misses() const { return misses_; }

 private:
  struct Entry {
    std::shared_ptr<const void> value;
    uint64_t bytes = 0;
    InputStates states;
    uint64_t used = 0;  ///< the larger the later
  };

  std::shared_ptr<const void> find(const std::string& key);
  void keep(const std::string& key, std::shared_ptr<const void> value, uint64_t bytes,
            InputStates states);

  const uint64_t most_bytes_;
  std::map<std::string, Entry> entries_;
  uint64_t bytes_ = 0, uses_ = 0, hits_ = 0, misses_ = 0;
};

/// As ReadCache::get(); without a cache it is made at each call.
template <typename T, typename Make, typename BytesOf>
std::shared_ptr<const T> remembered(ReadCache* cache, const std::string& key, const Make& make,
                                    const BytesOf& bytes_of) {
  return cache ? cache->get<T>(key, make, bytes_of) : std::make_shared<const T>(make());
}

}  // namespace tessera
