#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Each does all of it, however often a signal comes between; false, and errno tells why, where it
/// cannot. The last two leave the descriptor's own place alone.
bool write_all(int descriptor, std::span<const std::byte> bytes);
bool write_all_at(int descriptor, uint64_t at, std::span<const std::byte> bytes);
bool read_all_at(int descriptor, uint64_t at, std::span<std::byte> bytes);

/// What lies in a folder, in no order; of one that cannot be read, as far as it can.
std::vector<std::filesystem::directory_entry> entries_in(const std::filesystem::path& folder);

/// Sixteen letters that no other process, of any machine, takes for a file beside this one.
std::string unique_name();

}  // namespace tessera
