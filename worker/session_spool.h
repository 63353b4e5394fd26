#pragma once

#include "worker/result_spool.h"
#include "worker/worker_session.h"

namespace tessera {

struct SpooledResults {
  size_t kept = 0, dropped = 0;
};

/// What a session that ends could not hand in is for a worker that comes after it.
SpooledResults spool_unsent(WorkerSession& session, ResultSpool& spool);

/// Gives a session that has just been welcomed what was spooled; how many messages.
size_t hand_in_spooled(WorkerSession& session, ResultSpool& spool);

}  // namespace tessera
