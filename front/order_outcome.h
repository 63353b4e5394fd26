#pragma once

#include <optional>
#include <string>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// What of an order about a job that has not ended did not take effect, as its status shows: words
/// to follow "job N ". Nothing: all did, whatever else the farm has trouble with.
std::optional<std::string> unfulfilled(const v1::JobQuery& order, const v1::JobStatus& status);

}  // namespace tessera
