#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <string_view>

#include "base/digest.h"

namespace tessera {

/// What stat() tells of a file: while it stays equal, so does the content.
struct FileStamp {
  uint64_t device = 0, inode = 0, size = 0;
  int64_t modified = 0, changed = 0;  ///< nanoseconds since 1970
  bool is_proof = false;              ///< false of a file that was changed a moment ago, or of none

  /// Of a status that was taken just now.
  static FileStamp of(const struct stat& status);
  /// Whether a file with this stamp has the content that it had with `other`.
  bool proves_same_as(const FileStamp& other) const;
};

/// A content of a file: what it was when read or written.
struct FileVersion {
  Digest hash;      ///< zero of a file that was not read to its end: then the stamp decides
  FileStamp stamp;  ///< spares reading the file again; may be empty
};

/// What became of a file since a version of it.
enum class FileState { same, changed, deleted };
/// "same", "changed" or "deleted": as messages to the page have it.
std::string_view name_of(FileState state);

/// Whether the open regular file still is that version. The stamp is renewed where only that has
/// changed. Throws scene_error, by the name `shown`, where it cannot be read.
FileState state_of(int file, const struct stat& status, FileVersion& known, std::string_view shown);

}  // namespace tessera
