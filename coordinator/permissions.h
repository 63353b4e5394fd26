#pragma once

#include <optional>

#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/allow_list.h"

namespace tessera {

/// Whether the holder of a key may send that message to a coordinator, whatever it is about; if
/// not, the answer to it, which names both roles. What is not listed is for nobody.
std::optional<v1::Reject> refuse(const AllowedKey& sender, const v1::Envelope& message);

/// Whether it may give orders and submit jobs, not only look.
bool may_submit(const AllowedKey& sender);

}  // namespace tessera
