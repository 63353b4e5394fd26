#include "studio/files/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/folder.h"
#include "studio/files/file_kind.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostSampleBytes = uint64_t{64} << 20;

}  // namespace

fs::path Samples::folder_beside(const fs::path& program_folder) {
  // Programs are installed in lib/tessera; a build has them in bin.
  for (const char* const up : {"../..", ".."}) {
    std::error_code failure;
    const fs::path folder = fs::canonical(program_folder / up / "share/tessera/samples", failure);
    if (!failure) return folder;
  }
  return {};
}

Samples::Samples(fs::path folder) : folder_(std::move(folder)) {
  if (folder_.empty()) return;
  for (const auto& entry : entries_in(folder_)) {
    std::string name = entry.path().filename().string();
    const auto kind = file_kind_of(name);
    if (kind == FileKind::scene) {
      names_.push_back(std::move(name));
    } else if (kind == FileKind::model || kind == FileKind::picture) {
      companions_.push_back(std::move(name));
    }
  }
  std::sort(names_.begin(), names_.end());
  std::sort(companions_.begin(), companions_.end());
}

bool Samples::has(const std::string& name) const {
  return std::binary_search(names_.begin(), names_.end(), name);
}

std::vector<TemplateFile> Samples::files_of(const std::string& name) const {
  if (!has(name)) throw scene_error(fmt::format("'{}' is no sample", name));
  std::vector<TemplateFile> files;
  std::vector<std::string> names{name};
  for (size_t i = 0; i < names.size(); ++i) {
    files.push_back({names[i], read_input_file((folder_ / names[i]).string(), kMostSampleBytes)});
    for (const std::string& other : companions_) {
      const bool is_known = std::find(names.begin(), names.end(), other) != names.end();
      if (!is_known && files.back().text.find(other) != std::string::npos) names.push_back(other);
    }
  }
  return files;
}

}  // namespace tessera
