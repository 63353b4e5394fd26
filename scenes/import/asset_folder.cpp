#include "scenes/import/asset_folder.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/file.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

bool is_inside(const fs::path& folder, const fs::path& root) {
  const fs::path inside = folder.lexically_relative(root);
  return !inside.empty() && *inside.begin() != "..";
}

}  // namespace

fs::path whole_path(const fs::path& path) {
  std::error_code failure;
  const fs::path absolute = fs::absolute(path, failure);
  if (failure)
    throw scene_error(
        "the current folder is not there any more; expected another, or paths that begin with '/'");
  fs::path whole = fs::weakly_canonical(absolute, failure);
  if (failure) throw scene_error(fmt::format("{}: {}", path.string(), failure.message()));
  return whole;
}

AssetFolder::AssetFolder(const std::string& path, const std::string& assets)
    : root(whole_path(fs::path(path).has_parent_path() ? fs::path(path).parent_path() : ".")),
      folder(root) {
  if (assets.empty()) return;
  root = whole_path(assets);
  searches_root = true;
  if (!is_inside(folder, root)) folder = root;
}

AssetFolder AssetFolder::from(const fs::path& other) const {
  AssetFolder out = *this;
  out.folder = is_inside(other, root) ? other : root;
  return out;
}

std::optional<fs::path> AssetFolder::find(const std::string& reference) const {
  if (reference.empty()) return std::nullopt;
  const auto near = resolve_inside(root, (folder.lexically_relative(root) / reference).string());
  std::error_code ignored;
  if (!searches_root || (near && (is_input_file(*near) || fs::exists(*near, ignored)))) return near;
  return resolve_inside(root, reference);
}

std::string AssetFolder::shown_root() const {
  return searches_root ? fmt::format("the asset root '{}'", root.string()) : "the scene's folder";
}

}  // namespace tessera
