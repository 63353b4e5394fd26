#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace tessera {

/// Throws scene_error where `path` is missing, a folder, no regular file, empty, unreadable or
/// longer than `max_bytes`; returns its length.
uint64_t check_input_file(const std::string& path, uint64_t max_bytes);
/// The whole file, under the same conditions.
std::string read_input_file(const std::string& path, uint64_t max_bytes);
/// Writes beside `path`, then renames: the file appears whole or not at all. Throws render_error.
void write_output_file(const std::string& path, std::string_view bytes);

/// The file that `reference`, as written in a file of `folder`, means: relative, and inside the
/// folder even after links are followed; nothing otherwise. It need not exist.
std::optional<std::filesystem::path> resolve_inside(const std::filesystem::path& folder,
                                                    const std::string& reference);

/// The offset of the first byte that is not UTF-8, or npos.
size_t find_invalid_utf8(std::string_view text);
/// `text` where it is UTF-8; otherwise each stray byte taken as Latin-1. Protobuf's strings have to
/// be UTF-8, names in old files often are not.
std::string to_utf8(std::string_view text);

}  // namespace tessera
