#pragma once

#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <vector>

namespace tessera::testing {

// Simulations are of random schedules, each of which follows from its seed. TESSERA_SIM_SEED=N
// replays one seed and tells what happens; TESSERA_SIM_SEEDS=N sets how many there are in all.

constexpr uint64_t kShards = 8;

inline uint64_t from_environment(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

/// The seed to replay; 0: none.
inline uint64_t replayed_seed() { return from_environment("TESSERA_SIM_SEED", 0); }

/// What a shard, below kShards, plays of so many seeds. A replay is for the first one alone.
inline std::vector<uint64_t> seeds_of(uint64_t shard, uint64_t seeds) {
  if (const uint64_t seed = replayed_seed()) {
    return shard == 0 ? std::vector{seed} : std::vector<uint64_t>{};
  }
  std::vector<uint64_t> result(from_environment("TESSERA_SIM_SEEDS", seeds) / kShards);
  std::iota(result.begin(), result.end(), 1 + shard * result.size());
  return result;
}

}  // namespace tessera::testing
