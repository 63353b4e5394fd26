#include "studio/files/studio_settings.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/descriptors.h"
#include "base/digest.h"
#include "base/error.h"
#include "base/file.h"
#include "base/folder.h"
#include "studio/files/new_file.h"
#include "studio/files/user_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kGeneral = "studio.json";
constexpr const char* kFolders = "studio";
constexpr const char* kRecent = "studio_recent.json";
constexpr const char* kRecentFolders = "folders";

/// So deep are brackets within brackets: the library would go as deep by recursion.
int depth_of(std::string_view text) {
  int depth = 0, deepest = 0;
  bool is_in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') is_in_string = !is_in_string;
    if (c == '\\' && is_in_string) ++i;
    if (is_in_string) continue;
    if (c == '{' || c == '[') deepest = std::max(deepest, ++depth);
    if (c == '}' || c == ']') --depth;
  }
  return deepest;
}

json read(const fs::path& path) {
  try {
    const std::string text = read_input_file(path.string(), StudioSettings::kMostBytes);
    if (depth_of(text) <= StudioSettings::kMostDepth) {
      json settings = json::parse(text, nullptr, false);
      if (settings.is_object()) return settings;
    }
  } catch (const Error&) {  // not there, too large, no right
  }
  return json::object();
}

void write(const fs::path& path, const json& settings) {
  const std::string text = settings.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
  if (!settings.is_object() || text.size() > StudioSettings::kMostBytes ||
      depth_of(text) > StudioSettings::kMostDepth)
    throw render_error(fmt::format("settings are no object of at most {} bytes, {} deep",
                                   StudioSettings::kMostBytes, StudioSettings::kMostDepth));
  const fs::path place = output_place(path);  // some keep their settings elsewhere, by links
  make_private_folder(place.parent_path());
  const SpareDescriptors spare;
  OwnedDescriptor folder(::open(place.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  NewFile file(std::move(folder), place.filename().string(), place.string(), 0600);
  file.append(text);
  file.finish_over();
}

/// Removes what programs that were killed had begun to write.
void remove_unfinished(const fs::path& folder) {
  const OwnedDescriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  for (const auto& entry : entries_in(folder)) {
    NewFile::remove_unfinished(opened.get(), entry.path().filename().string());
  }
}

/// Removes the oldest beyond so many.
void keep_newest(const fs::path& folder, size_t most) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  for (const auto& entry : entries_in(folder)) {
    std::error_code failure;
    const auto written = entry.last_write_time(failure);
    if (!failure && entry.path().extension() == ".json") files.emplace_back(written, entry.path());
  }
  if (files.size() <= most) return;
  std::sort(files.begin(), files.end());
  for (size_t i = 0; i < files.size() - most; ++i) ::unlink(files[i].second.c_str());
}

}  // namespace

fs::path StudioSettings::default_folder() { return user_folder("XDG_CONFIG_HOME", ".config"); }

fs::path StudioSettings::file_of(const fs::path& opened) const {
  return folder_ / kFolders / fmt::format("{}.json", Digest::of(opened.string()).hex());
}

json StudioSettings::general() const {
  return folder_.empty() ? json::object() : read(folder_ / kGeneral);
}

json StudioSettings::of_folder(const fs::path& opened) const {
  return folder_.empty() ? json::object() : read(file_of(opened));
}

void StudioSettings::keep(const json& settings) const {
  if (!folder_.empty()) write(folder_ / kGeneral, settings);
}

void StudioSettings::keep_of_folder(const fs::path& opened, const json& settings) const {
  if (folder_.empty()) return;
  write(file_of(opened), settings);
  keep_newest(folder_ / kFolders, kMostFolders);
}

std::vector<std::string> StudioSettings::recent_folders() const {
  if (folder_.empty()) return {};
  const json settings = read(folder_ / kRecent);
  const auto list = settings.find(kRecentFolders);
  std::vector<std::string> folders;
  if (list == settings.end() || !list->is_array()) return folders;
  for (const json& each : *list) {
    if (folders.size() == kMostRecent) break;
    if (each.is_string() && fs::path(each.get_ref<const std::string&>()).is_absolute())
      folders.push_back(each);
  }
  return folders;
}

void StudioSettings::note_opened(const fs::path& folder) const {
  if (folder_.empty()) return;
  remove_unfinished(folder_);
  remove_unfinished(folder_ / kFolders);
  std::vector<std::string> folders = recent_folders();
  std::erase(folders, folder.string());
  folders.insert(folders.begin(), folder.string());
  if (folders.size() > kMostRecent) folders.resize(kMostRecent);
  write(folder_ / kRecent, {{kRecentFolders, folders}});
}

}  // namespace tessera
