#include "worker/session_spool.h"

#include <utility>

namespace tessera {

SpooledResults spool_unsent(WorkerSession& session, ResultSpool& spool) {
  SpooledResults results;
  for (const v1::Envelope& result : session.take_unsent()) {
    ++(spool.keep(session.hello(), session.farm(), result) ? results.kept : results.dropped);
  }
  return results;
}

size_t hand_in_spooled(WorkerSession& session, ResultSpool& spool) {
  return spool.hand_in(session.farm(),
                       [&](v1::Envelope result) { session.on_spooled(std::move(result)); });
}

}  // namespace tessera
