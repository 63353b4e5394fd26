#pragma once

#include <filesystem>
#include <string>

namespace tessera {

/// A new folder among the system's temporary ones, for this user alone; it is gone with this
/// object.
class TemporaryFolder {
 public:
  /// `name` begins its name. Throws render_error where it cannot be made.
  explicit TemporaryFolder(const std::string& name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// The path of a file in it.
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace tessera
