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
/// The whole file, under the same conditions. Of these two and is_input_file(), see InputScope.
std::string read_input_file(const std::string& path, uint64_t max_bytes);
/// Whether there is a regular file at `path`, or a text that stands for one.
bool is_input_file(const std::filesystem::path& path);
/// Throws usage_error, with `option` before it, where `output` is the file `input` itself, by
/// whatever name.
void check_not_input(const std::string& output, const std::string& input, std::string_view option);
/// Where a file written to `path` will lie: links followed, even those that lead to nothing yet.
std::filesystem::path output_place(const std::filesystem::path& path);
/// Throws usage_error, with `option` before it, for what write_output_file could not do later: a
/// folder that is missing or not writable, and a path that is neither new nor a regular file (a
/// link counts as what it leads to). Creates nothing.
void check_output_file(const std::string& path, std::string_view option = {});
/// Writes beside `path`, syncs and renames: the file appears whole or not at all, and what was
/// there stays until then. A link is kept and its target replaced; a device, FIFO, socket or folder
/// is never replaced. Throws render_error, and WorkCancelled where this thread's Cancellation asks
/// for an end before all is written. One call at a time.
void write_output_file(const std::string& path, std::string_view bytes);
/// Whether a file of that name is what a killed process left of a write_output_file.
bool is_unfinished_output(std::string_view name);
/// Removes what a write_output_file under way has written so far: for a signal handler whose next
/// act is to end the process.
void remove_unfinished_output();

/// The file that `reference`, as written in a file of `folder`, means: relative, and inside the
/// folder even after links are followed; nothing otherwise. It need not exist, its links must.
std::optional<std::filesystem::path> resolve_inside(const std::filesystem::path& folder,
                                                    const std::string& reference);

/// `text` without the byte order mark that some editors put before UTF-8.
std::string_view skip_byte_order_mark(std::string_view text);
/// The offset of the first byte that is not UTF-8, or npos.
size_t find_invalid_utf8(std::string_view text);
/// `text` where it is UTF-8; otherwise each stray byte taken as Latin-1. Protobuf's strings have to
/// be UTF-8, names in old files often are not.
std::string to_utf8(std::string_view text);

}  // namespace tessera
