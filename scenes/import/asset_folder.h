#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tessera {

/// Where `path` leads, from the root and with links followed. It need not exist. Throws scene_error
/// where the system cannot tell, as where the current folder was removed.
std::filesystem::path whole_path(const std::filesystem::path& path);

/// Where the files are that a scene's file names. A value.
struct AssetFolder {
  /// Of the file at `path`: its own folder alone; or `assets`, and there the file's own folder
  /// before all others if it is inside.
  explicit AssetFolder(const std::string& path, const std::string& assets = {});

  std::filesystem::path root;    ///< nothing outside of it is read
  std::filesystem::path folder;  ///< inside `root`: where names begin
  bool searches_root = false;    ///< for what is not in `folder`

  /// The same for what the file in `other` names, or from the root where `other` is not inside.
  AssetFolder from(const std::filesystem::path& other) const;
  /// The file that `reference` means, as resolve_inside says it, or by an absolute path to
  /// somewhere inside the root. It need not exist.
  std::optional<std::filesystem::path> find(const std::string& reference) const;

  struct Found {
    std::optional<std::filesystem::path> file;  ///< inside the root; it need not exist
    std::string note{};  ///< of a file that was taken for the one asked for: says so; else empty
  };
  /// The same of a file that a scene is made of, such as a picture. Where there is none, as by the
  /// path that it had on another machine, one with the last parts of that path, or its name alone,
  /// is taken for it: "/home/ann/chair/textures/wood.png" finds "textures/wood.png" or "wood.png".
  /// Where there is none of these either, upper and lower case count as the same, as on Windows.
  Found find_asset(const std::string& reference) const;
  /// What messages call the root: "the scene's folder", or "the asset root 'DIR'". With a reference
  /// that leads out of it comes which root would hold that, too.
  std::string shown_root(const std::string& reference = {}) const;

 private:
  /// The reference as the folders in `folder` spell it, with any letters of ASCII in the other
  /// case.
  std::optional<std::string> spelled(const std::string& reference) const;
};

}  // namespace tessera
