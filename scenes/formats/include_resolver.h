#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "scenes/import/asset_folder.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// The file that an include of `file` means, where `assets` are those of the scene's first file,
/// and what there is to say of it. Throws scene_error where it is outside of them.
AssetFolder::Found included_file(const AssetFolder& assets, const std::filesystem::path& file,
                                 const v1::Include& include);

/// Places the files that a scene includes into it, and what those include. Nothing outside the
/// assets of the first file is read, but for what place() is told to. Each file becomes one object,
/// however often it is placed.
class IncludeResolver {
 public:
  using Reader = std::function<LoadedScene(const std::string& path, const std::string& format)>;

  /// `reader` reads one file without its includes.
  IncludeResolver(const std::string& file, const std::string& assets, Reader reader);
  /// Places one file, of whatever folder, as `include` says; `read_whole` reads it with its
  /// includes.
  void place(LoadedScene& into, const v1::Include& include, const Reader& read_whole);
  /// Empties loaded.scene.includes(). Throws scene_error for files that are missing, outside the
  /// folder, include themselves, or are more than kMaxPlacements in all.
  void resolve(LoadedScene& loaded);

  static constexpr int kMaxDepth = 16;
  static constexpr int kMaxPlacements = 10000;

 private:
  struct Part {
    std::string object;  ///< the object's name; empty: `nodes` are copied in
    std::vector<v1::Node> nodes;
    std::vector<v1::Camera> cameras;
  };

  void resolve(LoadedScene& loaded, const std::filesystem::path& file);
  const Part& part(LoadedScene& into, const v1::Include& include, const std::filesystem::path& file,
                   const Reader& read);
  Part absorb(LoadedScene& into, const v1::Include& include, LoadedScene loaded,
              const std::filesystem::path& file);
  static void put(LoadedScene& into, const v1::Include& include, const Part& made,
                  const std::filesystem::path& file);
  std::string unique_prefix(const std::filesystem::path& file);

  std::filesystem::path first_;
  AssetFolder assets_;  ///< of the first file
  Reader reader_;
  std::map<std::string, Part> parts_;
  std::map<std::string, int> prefixes_;
  std::vector<std::filesystem::path> open_;
  int placements_ = 0;
};

}  // namespace tessera
