#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "studio/files/templates.h"

namespace tessera {

/// The scenes that ship with the program.
class Samples {
 public:
  /// Where they are installed for a program in that folder, or where its build has them; empty
  /// where neither is there.
  static std::filesystem::path folder_beside(const std::filesystem::path& program_folder);

  /// Without a folder there are none.
  explicit Samples(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }
  /// Sorted.
  const std::vector<std::string>& names() const { return names_; }
  bool has(const std::string& name) const;
  /// The scene, then the files that it names and that those name. Throws scene_error where there is
  /// no such sample, or where it cannot be read.
  std::vector<TemplateFile> files_of(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
  std::vector<std::string> companions_;  ///< all files that are not scenes
};

}  // namespace tessera
