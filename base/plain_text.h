#pragma once

#include <string>
#include <string_view>

namespace tessera {

/// `text` for a terminal or a log: control characters (C0 and C1, DEL) and those that change the
/// direction of writing are written out as \n, \x1b or \u202e. Line ends stay where `keeps_lines`.
std::string escape_controls(std::string_view text, bool keeps_lines = false);

/// Whether a text begins as one in UTF-16 does: with a byte-order mark, or with a first character
/// that is ASCII.
bool is_utf16(std::string_view bytes);
/// Throws scene_error where the text of the file `name` is in UTF-16 or UTF-32.
void refuse_wide_text(std::string_view bytes, const std::string& name);

}  // namespace tessera
