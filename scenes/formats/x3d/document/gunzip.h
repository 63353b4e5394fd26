#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera {

/// Whether the bytes begin as gzip's (RFC 1952) do.
bool is_gzip(std::string_view bytes);
/// What they hold. Throws scene_error naming `file` for broken data and for more than `most` bytes.
std::string gunzip(std::string_view bytes, size_t most, const std::string& file);

}  // namespace tessera
