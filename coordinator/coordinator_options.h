#pragma once

#include <cstdint>
#include <string>

#include "base/monotonic.h"
#include "proto/wire/version.h"

namespace tessera {

/// How a coordinator behaves; the defaults are for a farm.
struct CoordinatorOptions {
  // When it gives up on whom: lengths of time, all above zero.
  Time heartbeat = std::chrono::seconds(1);
  Time suspect_after = std::chrono::milliseconds(2500);  ///< silence: others copy its work
  Time lost_after = std::chrono::seconds(5);             ///< silence: its work is given to others
  Time lease = std::chrono::seconds(10);                 ///< a tile without progress
  Time settle = std::chrono::milliseconds(2500);  ///< for what was sent to show in heartbeats
  Time greeting = std::chrono::seconds(15);       ///< for a local process to say hello
  Time client_timeout = std::chrono::seconds(15);
  /// A second copy of a tile is issued no sooner than this after the first.
  Time speculate_after = std::chrono::milliseconds(100);
  /// No tile is split into parts that take less than this.
  Time smallest_part = std::chrono::milliseconds(4);

  // How much it takes on.
  /// What all submissions of clients together may come to take: blobs, scenes and films.
  uint64_t client_budget_bytes = uint64_t{32} << 30;
  int expected_workers = 4;  ///< threads that trace, for the choice of a tile size; above 0

  /// The share of tiles that a second worker traces too, from 0 to 1, and what chooses them.
  double verify = 0;
  uint64_t verify_key = 0;

  // What it tells workers of itself.
  uint32_t protocol_major = kProtocolMajor;
  std::string numerics_id = kNumericsId;

  // What RenderLoop fills in, from its transport, this host and the clock.
  bool compress_pixels = false;  ///< saves network, costs time: for workers on other machines
  std::string bulk_endpoint;     ///< as in Welcome
  /// Where workers can map the memory of this process; 0: they cannot.
  uint32_t shared_by_process = 0;
  std::string host;    ///< of the coordinator: whose process ids are its own
  uint64_t farm = 0;   ///< of the store; 0: jobs end with this process
  uint64_t epoch = 0;  ///< another at each start of a coordinator, below 2^44
};

}  // namespace tessera
