#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/formats/x3d/document/x3d_document.h"
#include "scenes/import/asset_folder.h"

namespace tessera {

/// The files that an X3D scene may name: those in the assets of its first file. Names are relative
/// to the folder where its own begin, with '/' between. Nothing is on the network.
class X3dFiles {
 public:
  static constexpr size_t kMaxFiles = 1000;  ///< that are read as parts of one scene
  static constexpr size_t kMaxOpen = 16;     ///< one inside the other

  /// Without a folder no file is looked for.
  X3dFiles() = default;
  X3dFiles(const std::string& first_file, const std::string& assets);

  bool has_folder() const { return assets_.has_value(); }

  /// What became of a URL.
  struct Found {
    std::string file{};    ///< empty: not found
    std::string reason{};  ///< then: why not
    std::string note{};    ///< as of AssetFolder::Found
  };
  /// The file that `url` names, as written in a file of `folder`. `takes_others`: another one may
  /// be taken for it, as AssetFolder::find_asset() looks for it.
  Found find(const std::string& url, const std::string& folder, bool takes_others) const;
  /// The URL as messages show it: what a data: URI holds is cut off.
  static std::string shown(const std::string& url);

  /// The folder of a file found.
  static std::string folder_of(const std::string& file);
  std::string full(const std::string& file) const {
    return (assets_->folder / file).lexically_normal().string();
  }

  /// The files that are being read, outermost first, the objects that those read became, and why
  /// others could not be.
  std::vector<std::string> open;
  std::map<std::string, std::string> objects, problems;
  /// Those that were read for their prototypes, which documents refer to, and the nodes and bytes
  /// that they keep.
  std::map<std::string, std::shared_ptr<const X3dDocument>> prototypes;
  size_t prototype_nodes = 0, prototype_bytes = 0;
  /// Whether no more may be read.
  bool is_full() const {
    return open.size() >= kMaxOpen ||
           objects.size() + problems.size() + prototypes.size() >= kMaxFiles;
  }
  /// Whether a file is a part of itself, or they are too many: whatever is left out, that is wrong.
  bool is_endless = false;

 private:
  std::optional<AssetFolder> assets_;
};

}  // namespace tessera
