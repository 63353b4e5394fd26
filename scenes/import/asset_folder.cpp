#include "scenes/import/asset_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/lower_case.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

bool is_inside(const fs::path& folder, const fs::path& root) {
  const fs::path inside = folder.lexically_relative(root);
  return !inside.empty() && *inside.begin() != "..";
}

/// As a file of Windows means it.
std::string with_slashes(std::string reference) {
  std::replace(reference.begin(), reference.end(), '\\', '/');
  return reference;
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
  if (reference.empty() || reference.find('\0') != std::string::npos) return std::nullopt;
  if (fs::path(reference).is_absolute()) {
    std::error_code failure;
    const fs::path whole = fs::weakly_canonical(reference, failure);
    if (failure || !is_inside(whole, root)) return std::nullopt;
    return resolve_inside(root, whole.lexically_relative(root).string());
  }
  const auto near = resolve_inside(root, (folder.lexically_relative(root) / reference).string());
  std::error_code ignored;
  if (!searches_root || (near && (is_input_file(*near) || fs::exists(*near, ignored)))) return near;
  return resolve_inside(root, reference);
}

std::optional<std::string> AssetFolder::spelled(const std::string& reference) const {
  fs::path spelled;
  for (const fs::path& step : fs::path(reference)) {
    std::error_code failure;
    const fs::path place = fs::weakly_canonical(folder / spelled, failure);
    if (failure || !is_inside(place, root)) return std::nullopt;
    if (fs::exists(place / step, failure)) {
      spelled /= step;
      continue;
    }
    const std::string wanted = lower_case(step.string());
    std::string best;
    for (fs::directory_iterator entry(place, failure), end; !failure && entry != end;
         entry.increment(failure)) {
      const std::string name = entry->path().filename().string();
      if (lower_case(name) == wanted && (best.empty() || name < best)) best = name;
    }
    if (best.empty()) return std::nullopt;
    spelled /= best;
  }
  return spelled.string();
}

AssetFolder::Found AssetFolder::find_asset(const std::string& reference) const {
  constexpr size_t kMostParts = 16;
  Found found{find(reference)};
  if (found.file && is_input_file(*found.file)) return found;
  const std::string path = with_slashes(reference);
  std::vector<std::string> ends{path};  // from the longest
  for (size_t slash = path.find('/'); slash != path.npos; slash = path.find('/', slash + 1)) {
    ends.push_back(path.substr(slash + 1));
  }
  if (ends.size() > kMostParts) {
    ends.erase(ends.begin() + 1, ends.end() - static_cast<ptrdiff_t>(kMostParts - 1));
  }
  for (const bool in_any_case : {false, true}) {
    for (const std::string& end : ends) {
      if (end.empty() || end.front() == '/') continue;
      auto name = in_any_case ? spelled(end) : end;
      if (!name && searches_root) name = from(root).spelled(end);
      if (!name) continue;
      auto file = find(*name);
      if (!file || !is_input_file(*file)) continue;
      found.note = fmt::format("'{}' is not {}; '{}' is taken for it", reference,
                               found.file ? "there" : fmt::format("inside {}", shown_root()),
                               file->lexically_relative(root).generic_string());
      found.file = std::move(file);
      return found;
    }
  }
  return found;
}

std::string AssetFolder::shown_root(const std::string& reference) const {
  const std::string shown =
      searches_root ? fmt::format("the asset root '{}'", root.string()) : "the scene's folder";
  const fs::path target = (folder / with_slashes(reference)).lexically_normal();
  fs::path wider = root;
  while (!is_inside(target, wider)) wider = wider.parent_path();
  const bool would_help = wider != root && wider != wider.root_path();
  return shown + (would_help ? fmt::format(" (--assets '{}' would hold it)", wider.string()) : "");
}

}  // namespace tessera
