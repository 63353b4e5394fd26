#pragma once

#include <functional>
#include <string>

#include "client/farm_client.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// The number of the job that `text` means: its number, or the name of the latest that has it; of
/// several `tell` is told which that is.
/// Throws usage_error, with the nearest name, where there is none.
uint64_t find_job(FarmClient& client, const std::string& text,
                  const std::function<void(const std::string&)>& tell);

}  // namespace tessera
