#pragma once

#include <string>

#include "coordinator/jobs/active_frame.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// Adds to `answer` the light of the tiles that were done after those that the query tells of, as
/// much as one message takes. `opening` is the coordinator's, as in Welcome. A query of another
/// opening, or of this frame traced before, is answered from the first tile on.
void add_done_tiles(const ActiveFrame& frame, const std::string& opening,
                    const v1::DoneTilesQuery& query, v1::DoneTiles& answer);

}  // namespace tessera
