#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// What lies in a folder, in no order, and no more than `most`; of one that cannot be read, as far
/// as it can.
std::vector<std::filesystem::directory_entry> entries_in(const std::filesystem::path& folder,
                                                         size_t most = SIZE_MAX);
/// Makes the names in it durable, where the file system can do that for a folder.
void sync_folder(const std::filesystem::path& folder);
/// Sixteen letters that no other process, of any machine, takes for a file there.
std::string unique_name();

}  // namespace tessera
