#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/owned_descriptor.h"
#include "studio/files/file_kind.h"
#include "studio/files/file_version.h"
#include "studio/files/new_file.h"

namespace tessera {

struct FileContent {
  std::string bytes;
  bool is_whole = true;  ///< false where the file has more than was asked for: its beginning
  uint64_t size = 0;     ///< of the file
  FileVersion version;
};

/// What a save did: it has saved where `state` is `same`, else the file is as it was.
struct SaveResult {
  FileState state = FileState::same;
  FileVersion version;  ///< of what was saved
};

struct FileEntry {
  std::string name;  ///< its path below the folder, with '/'
  FileKind kind = FileKind::scene;
  uint64_t size = 0;  ///< bytes; 0 for folders
  friend bool operator==(const FileEntry&, const FileEntry&) = default;
};

struct FileList {
  std::vector<FileEntry> entries;  ///< sorted by name, a folder right before what is in it
  bool is_truncated = false;
};

/// Of names that were to be new, those of files that are there.
struct ExistingFiles {
  std::string first;
  size_t count = 0;

  void add(const std::string& name) {
    if (count++ == 0) first = name;
  }
  /// Why they are not written, where there are any.
  std::string why() const;
};

/// The files below a folder, for someone who only knows their names: relative paths in UTF-8 with
/// '/'. Only regular files below the folder are ever touched, also where links lead elsewhere or
/// are changed meanwhile, and none whose path has a part that begins with '.'. Methods may be
/// called by any thread. All throw Error for what cannot be done: scene_error when reading,
/// render_error when writing.
class Folder {
 public:
  enum class Access { read_write, read_only };
  static constexpr size_t kMostEntries = 5000;
  static constexpr int kMostDepth = 8;

  /// Throws a usage error where `path` is no folder.
  explicit Folder(const std::filesystem::path& path, Access access = Access::read_write);

  const std::filesystem::path& path() const { return path_; }
  bool is_read_only() const { return access_ == Access::read_only; }

  /// Scenes, models, pictures and the folders that hold any, or nothing at all.
  FileList list() const;
  /// The one name of the file, of those that links give it.
  std::string canonical(const std::string& name) const;
  /// At most so many first bytes.
  FileContent read(const std::string& name, size_t most_bytes) const;
  /// Whether the file still is that version; its stamp is renewed where only that has changed.
  FileState state(const std::string& name, FileVersion& known) const;

  /// The name, or the first one with a number behind it that nothing has.
  std::string free_name(const std::string& name) const;
  /// Removes what programs that were killed had begun to write.
  void remove_unfinished() const;

  /// Throws where no file could be written there now, be it over one. Returns whether there is one.
  bool check_writable(const std::string& name) const;
  /// Makes a file that was not there; its folder must be.
  FileVersion create(const std::string& name, std::string_view bytes) const;
  /// The same piece by piece: the file appears with NewFile::finish().
  NewFile start(const std::string& name) const;
  /// Replaces the content of a file that is `expected` or, without that, whatever it is, also
  /// nothing. Mode and owner stay, also hard links; a link's target is replaced. Where it fails,
  /// or the program ends meanwhile, the file is as it was; that of several hard links, which is
  /// written where it lies, has a copy beside it meanwhile.
  SaveResult save(const std::string& name, std::string_view bytes,
                  const std::optional<FileVersion>& expected) const;
  /// Makes a folder in one that is there.
  void make_folder(const std::string& name) const;

 private:
  /// Where a name leads.
  struct Place {
    std::string name;        ///< as messages have it
    std::string canonical;   ///< without links
    OwnedDescriptor folder;  ///< that it lies in; none where that is not there
    std::string leaf;        ///< its name in there
  };
  Place find(const std::string& name) const;
  Place find_to_write(const std::string& name) const;
  /// Where nothing is yet.
  Place find_free(const std::string& name) const;

  std::filesystem::path path_;  ///< absolute, without links
  Access access_;
};

}  // namespace tessera
