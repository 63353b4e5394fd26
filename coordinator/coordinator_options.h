#pragma once

#include <cstdint>
#include <string>

#include "base/monotonic.h"
#include "coordinator/jobs/job_rules.h"
#include "proto/wire/version.h"

namespace tessera {

/// How a coordinator behaves; the defaults are for a farm.
struct CoordinatorOptions : JobRules {
  // When it gives up on whom: lengths of time, all above zero.
  Time heartbeat = std::chrono::seconds(1);
  Time suspect_after = std::chrono::milliseconds(2500);  ///< silence: others copy its work
  Time lost_after = std::chrono::seconds(5);             ///< silence: its work is given to others
  Time greeting = std::chrono::seconds(15);              ///< for a local process to say hello
  Time client_timeout = std::chrono::seconds(15);

  // What it tells workers of itself.
  uint32_t protocol_major = kProtocolMajor;
  std::string numerics_id = kNumericsId;

  // What RenderLoop tells each peer by itself, from the way by which it comes.
  bool compress_pixels = false;  ///< saves network, costs time: for workers on other machines
  std::string bulk_endpoint;     ///< as in Welcome

  // What RenderLoop fills in, from this host.
  uint64_t farm = 0;  ///< as in Welcome; 0: of no store, so that it ends with this process
  std::string host;   ///< of the coordinator: whose process ids are its own
};

}  // namespace tessera
