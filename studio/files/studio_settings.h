#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

/// Small JSON objects that the program keeps for its page: one for all, and one a folder with
/// what was open in it. Files that are damaged, too large or not there count as empty objects.
class StudioSettings {
 public:
  static constexpr size_t kMostBytes = size_t{256} << 10;
  static constexpr int kMostDepth = 32;
  /// Nice levels of the workers: by default the browser beside them is never starved.
  static constexpr int kWorkersNice = 10, kMostNice = 19;
  /// Of those of single folders the ones that were kept last stay.
  static constexpr size_t kMostFolders = 200;
  static constexpr size_t kMostRecent = 10;

  /// $XDG_CONFIG_HOME/tessera, or else ~/.config/tessera; empty where there is neither.
  static std::filesystem::path default_folder();
  /// Keeps them in `folder`/studio.json, studio_recent.json and studio/. An empty path keeps
  /// nothing.
  explicit StudioSettings(std::filesystem::path folder) : folder_(std::move(folder)) {}

  nlohmann::json general() const;
  nlohmann::json of_folder(const std::filesystem::path& opened) const;
  /// Throw render_error where `settings` are no object, too large, or cannot be written: what was
  /// kept before then stays.
  void keep(const nlohmann::json& settings) const;
  void keep_of_folder(const std::filesystem::path& opened, const nlohmann::json& settings) const;

  /// The folders that note_opened() was called for, absolute, the newest first.
  std::vector<std::string> recent_folders() const;
  /// Removes too what programs that were killed left half written. Throws render_error as keep()
  /// does.
  void note_opened(const std::filesystem::path& folder) const;

 private:
  std::filesystem::path file_of(const std::filesystem::path& opened) const;

  std::filesystem::path folder_;
};

}  // namespace tessera
