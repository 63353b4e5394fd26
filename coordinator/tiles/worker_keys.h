#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>

#include "coordinator/tiles/tile_piece.h"

namespace tessera {

/// Ids with this bit are the coordinator's own: no worker may have one.
inline constexpr WorkerId kReservedId = WorkerId{1} << 63;
/// Stands for no worker: its pixels were kept from before, and nobody knows by whose key.
inline constexpr WorkerId kFromStore = ~WorkerId{0};

/// By whose key each worker was let in. Who holds a key can run any number of processes, so where a
/// farm has keys of at least two workers, all workers of a key are one voter: tiles are checked,
/// disputes decided and scenes refused by different voters. Elsewhere each process is a voter,
/// which finds faults, but proves nothing against whoever holds the key.
/// Workers are remembered for good: late pixels of one that is gone are still its key's.
class WorkerKeys {
 public:
  using Voter = uint64_t;

  /// So many keys of workers are on the list; 0: the farm has no keys.
  void set_listed(size_t keys) { listed_ = keys; }
  size_t listed() const { return listed_; }
  /// Whether all workers of a key are one voter.
  bool by_key() const { return listed_ >= 2; }

  /// The worker came by that key, whose holder is called `name`. Without keys both are empty. A
  /// worker's id stays with the first key that it came by.
  void note(WorkerId worker, const std::string& key, const std::string& name);
  /// Stands for the worker, long gone, that traced what a store has under that key.
  WorkerId note_stored(const std::string& key);

  /// The public key; empty: there was none, or it is not known.
  const std::string& key_of(WorkerId worker) const;
  /// What people call that key: its holder's name or, where it was not heard of in the life of this
  /// coordinator, its first digits.
  std::string name_of(const std::string& key) const;
  Voter voter_of(WorkerId worker) const;

 private:
  size_t listed_ = 0;
  struct Holder {
    const std::string* key;  ///< that of names_
    Voter voter;
  };
  std::unordered_map<WorkerId, Holder> holders_;
  std::map<std::string, std::string> names_;  ///< by key
};

}  // namespace tessera
