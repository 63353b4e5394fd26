#include "scenes/import/asset_folder.h"

#include "base/file.h"

namespace tessera {

namespace fs = std::filesystem;

AssetFolder::AssetFolder(const std::string& path, const std::string& assets)
    : root(fs::weakly_canonical(fs::absolute(path).parent_path())), folder(root) {
  if (assets.empty()) return;
  root = fs::weakly_canonical(fs::absolute(assets));
  searches_root = true;
  const fs::path inside = folder.lexically_relative(root);
  if (inside.empty() || *inside.begin() == "..") folder = root;
}

std::optional<fs::path> AssetFolder::find(const std::string& reference) const {
  if (reference.empty()) return std::nullopt;
  const auto near = resolve_inside(root, (folder.lexically_relative(root) / reference).string());
  std::error_code ignored;
  if (!searches_root || (near && fs::exists(*near, ignored))) return near;
  return resolve_inside(root, reference);
}

}  // namespace tessera
