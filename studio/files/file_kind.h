#pragma once

#include <optional>
#include <string_view>

namespace tessera {

/// What the list of files tells apart.
enum class FileKind { folder, scene, model, picture };

/// "folder", "scene", "model" or "picture": as messages to the page have it.
std::string_view name_of(FileKind kind);
/// Told by the ending, in any case: what scenes are read from, what they include (.mtl among
/// them), and pictures; nothing for all other files.
std::optional<FileKind> file_kind_of(std::string_view file_name);

/// Whether scenes read files of that name: those of a kind, and the ones that hold numbers of glTF.
bool is_read_by_scenes(std::string_view file_name);

}  // namespace tessera
