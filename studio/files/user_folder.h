#pragma once

#include <filesystem>

namespace tessera {

/// The folder "tessera" in the one that the variable names (XDG_STATE_HOME), or in `fallback` below
/// the user's own; empty where there is neither.
std::filesystem::path user_folder(const char* variable, const char* fallback);
/// Makes the folder where it is not there, for this account alone. Throws render_error.
void make_private_folder(const std::filesystem::path& folder);

}  // namespace tessera
