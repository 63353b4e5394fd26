#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

/// Each does all of it, however often a signal comes between; false, and errno tells why, where it
/// cannot. The last two leave the descriptor's own place alone.
bool write_all(int descriptor, std::span<const std::byte> bytes);
bool write_all_at(int descriptor, uint64_t at, std::span<const std::byte> bytes);
bool read_all_at(int descriptor, uint64_t at, std::span<std::byte> bytes);

/// Holds a file or folder until `descriptor` is closed, which also the kernel does for whoever is
/// killed: unlike a process's number, that means the same in every container. False where another
/// holds it, or it has no name any more. `status` is filled in where it is held.
bool hold_alone(int descriptor, struct stat& status);

}  // namespace tessera
