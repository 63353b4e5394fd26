#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "base/descriptors.h"
#include "base/file.h"
#include "base/open_beneath.h"
#include "studio/files/file_name.h"
#include "studio/files/folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct CloseFolder {
  void operator()(DIR* folder) const { ::closedir(folder); }
};

std::string join(const std::string& folder, const std::string& name) {
  return folder.empty() ? name : folder + '/' + name;
}

bool is_below(const std::string& path, const std::string& folder) {
  return folder.empty() || path == folder || path.starts_with(folder + '/');
}

/// Sorts "a/b" behind "a" and before "a.b".
bool comes_before(const FileEntry& a, const FileEntry& b) {
  return std::lexicographical_compare(
      a.name.begin(), a.name.end(), b.name.begin(), b.name.end(), [](char x, char y) {
        const auto rank = [](char c) { return c == '/' ? 0 : static_cast<unsigned char>(c); };
        return rank(x) < rank(y);
      });
}

/// What is in the open folder, in no order; nothing where it cannot be read.
std::optional<std::vector<std::string>> names_within(OwnedDescriptor opened, size_t most) {
  if (opened.get() < 0) return {};
  const std::unique_ptr<DIR, CloseFolder> folder(::fdopendir(opened.get()));
  if (!folder) return {};
  opened.release();
  std::vector<std::string> names;
  while (const dirent* entry = ::readdir(folder.get())) {
    const std::string name = entry->d_name;
    if (name == "." || name == "..") continue;
    names.push_back(name);
    if (names.size() == most) break;
  }
  return names;
}

/// Goes through a folder level by level, so that what lies deep is what a limit leaves out.
class Lister {
 public:
  explicit Lister(const fs::path& path) : path_(path) {
    const SpareDescriptors spare;
    root_ = OwnedDescriptor(::open(path.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    found_.push_back({});
    found_.front().depth = 0;
  }

  FileList list() {
    for (size_t i = 0; i < found_.size(); ++i) {
      if (found_[i].entry.kind == FileKind::folder) look_into(i);
    }
    keep_folders_of_files();
    FileList out;
    out.is_truncated = is_truncated_;
    for (size_t i = 1; i < found_.size(); ++i) {
      if (!found_[i].is_kept) continue;
      if (out.entries.size() == Folder::kMostEntries) {
        out.is_truncated = true;
        break;
      }
      out.entries.push_back(std::move(found_[i].entry));
    }
    std::sort(out.entries.begin(), out.entries.end(), comes_before);
    return out;
  }

 private:
  /// Of all that is in folders, whether it is listed or not.
  static constexpr size_t kMostSeen = 100'000;

  struct Found {
    FileEntry entry{.name = {}, .kind = FileKind::folder};
    std::string canonical;
    size_t parent = 0;
    int depth = 1;
    bool is_kept = false;
  };

  void look_into(size_t index) {
    const std::string name = found_[index].entry.name, canonical = found_[index].canonical;
    const int depth = found_[index].depth;
    const auto [names, is_empty] = names_in(canonical);
    found_[index].is_kept = is_empty;
    if (depth == Folder::kMostDepth) {
      is_truncated_ |= !names.empty();
      return;
    }
    for (const std::string& leaf : names) {
      Found next;
      next.entry.name = join(name, leaf);
      next.canonical = join(canonical, leaf);
      next.parent = index;
      next.depth = depth + 1;
      if (fault_of_name(next.entry.name).empty() && examine(next, canonical))
        found_.push_back(std::move(next));
    }
  }

  /// Sorted, and whether there is nothing at all, hidden or not.
  std::pair<std::vector<std::string>, bool> names_in(const std::string& canonical) {
    auto names = names_within(open_beneath(root_.get(), canonical, O_RDONLY | O_DIRECTORY),
                              kMostSeen + 1 - seen_);
    if (!names) return {{}, false};
    const bool is_empty = names->empty();
    std::erase_if(*names, [](const std::string& name) { return name.front() == '.'; });
    seen_ += names->size();
    if (seen_ > kMostSeen) {
      is_truncated_ = true;
      names->pop_back();
      --seen_;
    }
    std::sort(names->begin(), names->end());
    return {*std::move(names), is_empty};
  }

  /// Fills in what it is; false where it is nothing to list.
  bool examine(Found& found, const std::string& parent) {
    struct stat status;
    OwnedDescriptor opened = open_beneath(root_.get(), found.canonical, O_PATH);
    if (opened.get() < 0) {  // a link
      const auto target = resolve_inside(path_, found.canonical);
      if (!target) return false;
      found.canonical = target->lexically_relative(path_).string();
      // Not into what it is in, for ever.
      if (!fault_of_name(found.canonical).empty() || is_below(parent, found.canonical))
        return false;
      opened = open_beneath(root_.get(), found.canonical, O_PATH);
    }
    if (opened.get() < 0 || ::fstat(opened.get(), &status) != 0) return false;
    if (S_ISDIR(status.st_mode)) return true;
    const auto kind = file_kind_of(found.entry.name);
    if (!kind || !S_ISREG(status.st_mode)) return false;
    found.entry.kind = *kind;
    found.entry.size = static_cast<uint64_t>(status.st_size);
    found.is_kept = true;
    return true;
  }

  void keep_folders_of_files() {
    for (size_t i = found_.size(); i-- > 1;) {
      if (found_[i].is_kept) found_[found_[i].parent].is_kept = true;
    }
  }

  const fs::path& path_;
  OwnedDescriptor root_;
  std::vector<Found> found_;  ///< the folder itself first; each behind what it is in
  size_t seen_ = 0;
  bool is_truncated_ = false;
};

}  // namespace

FileList Folder::list() const { return Lister(path_).list(); }

void Folder::remove_unfinished() const {
  constexpr size_t kMostNames = 100'000;
  std::vector<std::string> folders{""};
  for (const FileEntry& entry : list().entries) {
    if (entry.kind == FileKind::folder) folders.push_back(canonical(entry.name));
  }
  const SpareDescriptors spare;
  const OwnedDescriptor root(::open(path_.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  for (const std::string& each : folders) {
    const OwnedDescriptor folder = open_beneath(root.get(), each, O_RDONLY | O_DIRECTORY);
    if (folder.get() < 0) continue;
    const auto names =
        names_within(OwnedDescriptor(::fcntl(folder.get(), F_DUPFD_CLOEXEC, 0)), kMostNames);
    for (const std::string& name : names.value_or(std::vector<std::string>()))
      NewFile::remove_unfinished(folder.get(), name);
  }
}

}  // namespace tessera
