#pragma once

#include <functional>
#include <string>

#include "client/farm_client.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// The number of the job that `text` means: its number, or its name. "name:TEXT" is always a name,
/// also where TEXT is a number. Both functions throw usage_error, with the nearest name, where
/// there is no such job.

/// The job to be asked about: of several of that name the latest, and `tell` is told so.
uint64_t find_job(FarmClient& client, const std::string& text,
                  const std::function<void(const std::string&)>& tell);
/// The job to be changed, which no other may be taken for: throws usage_error with the numbers of
/// all that have the name.
uint64_t find_job_to_change(FarmClient& client, const std::string& text);

}  // namespace tessera
