#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tessera {

/// Where the files are that a scene's file names. A value.
struct AssetFolder {
  /// Of the file at `path`: its own folder alone; or `assets`, and there the file's own folder
  /// before all others if it is inside.
  explicit AssetFolder(const std::string& path, const std::string& assets = {});

  std::filesystem::path root;    ///< nothing outside of it is read
  std::filesystem::path folder;  ///< inside `root`: where names begin
  bool searches_root = false;    ///< for what is not in `folder`

  /// The file that `reference` means, as resolve_inside says it. It need not exist.
  std::optional<std::filesystem::path> find(const std::string& reference) const;
};

}  // namespace tessera
