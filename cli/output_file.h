#pragma once

#include <filesystem>
#include <string_view>

namespace tessera {

/// Throws usage_error, naming `option`, unless `path` can be written: its folder exists and is
/// writable, and it is no folder itself. Creates nothing.
void check_output_file(std::string_view option, const std::filesystem::path& path);

}  // namespace tessera
