#pragma once

#include <string>

#include "client/farm_client.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// The number of the job that `text` means: its number, or the name of the latest that has it; of
/// several it says on standard error which that is.
/// Throws usage_error, with the nearest name, where there is none.
uint64_t find_job(FarmClient& client, const std::string& text);

}  // namespace tessera
