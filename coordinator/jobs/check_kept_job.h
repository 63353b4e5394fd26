#pragma once

#include <cstdint>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// The largest number of a job; the numbers of its frames are made of it.
inline constexpr uint64_t kMaxJobNumber = uint64_t{1} << 40;

/// Throws an Error where no coordinator can have accepted the job: what is kept of it is damaged,
/// though it is a message.
void check_kept_job(const v1::KeptJob& kept);

}  // namespace tessera
