#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/digest.h"

namespace tessera {

/// Openings, jobs and frames are named by 16 bytes that nobody else draws. Numbers of jobs and
/// leases repeat in a copy of a store; these do not, so what is said under them is about this
/// very frame, of this very farm.
inline constexpr size_t kIdBytes = 16;

/// From the system's randomness.
std::string draw_opening();
/// The id of the job that got that number from the coordinator of that opening.
std::string job_id_of(const std::string& opening, uint64_t number);
/// The id of a frame of the job, under which workers speak of it: the scene, the settings and the
/// crop are in its tile_key(), the grid in the tile size.
std::string frame_id_of(const std::string& job_id, uint64_t frame_number, const Digest& tile_key,
                        int tile_size);
/// An id in hexadecimal, for people.
std::string id_text(const std::string& id);
/// The first 64 bits of an id, not 0.
uint64_t number_of(const std::string& id);

}  // namespace tessera
