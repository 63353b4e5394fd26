#pragma once

#include <sys/types.h>

#include <string>

namespace tessera {

/// The file of an ipc endpoint, from before it is bound to its end.
class SocketFile {
 public:
  SocketFile() = default;
  /// Removes the file, if it is still the one that was bound.
  ~SocketFile();
  SocketFile(const SocketFile&) = delete;
  SocketFile& operator=(const SocketFile&) = delete;

  /// Throws usage_error where something else than a socket that nobody serves is at `path`: binding
  /// would remove it.
  static void check_free(const std::string& path);
  /// To be called when it has just been bound.
  void own(const std::string& path);

 private:
  std::string path_;  ///< empty: nothing to remove
  dev_t device_ = 0;
  ino_t inode_ = 0;
};

}  // namespace tessera
