#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera {

/// So many first bytes of a file tell its format.
inline constexpr size_t kFormatBytes = 264;

/// The format of the file that begins with `head` (all of it, or kFormatBytes), as OpenImageIO
/// calls it. It is told by the content alone, and is one of those whose files hold all pixels in
/// themselves. Throws a scene error that begins with `name` for all else.
const char* image_format_of(const std::string& name, std::string_view head);

}  // namespace tessera
