#pragma once

#include <sys/stat.h>

#include <optional>
#include <string>
#include <string_view>

#include "base/owned_descriptor.h"
#include "studio/files/file_version.h"

namespace tessera {

/// In errno: it is a folder, FIFO, socket or device.
inline constexpr int kNotRegular = -1;

/// Opens a regular file of a folder, and no link, without waiting for anybody and without opening
/// a device. -1 where it cannot, with errno; `status` is filled in where it can.
OwnedDescriptor open_regular(int folder, const std::string& leaf, int flags, struct stat& status);
/// In words, for what open_regular leaves in errno.
std::string reason_not_opened(int error);

/// What the open file has, which was written with `bytes` and is known by its name.
FileVersion version_of(int file, std::string_view bytes);

/// A regular file that was opened and is to get another content.
struct ReplacedFile {
  int folder = -1;
  std::string leaf;   ///< its name in the folder
  std::string shown;  ///< its name in messages
  int descriptor = -1;
  struct stat status;  ///< when it was opened
};

/// Replaces the content of the file, as Folder::save says. Nothing where `keeps_others` and it was
/// changed since it was opened, and then it is as it was. Throws render_error.
std::optional<FileVersion> replace_file(const ReplacedFile& file, std::string_view bytes,
                                        bool keeps_others);

}  // namespace tessera
