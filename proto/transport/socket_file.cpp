#include "proto/transport/socket_file.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>

#include "base/error.h"

namespace tessera {
namespace {

/// Whether a process listens there, or may: only a refusal says that none does.
bool in_use(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return true;
  path.copy(address.sun_path, path.size());
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return true;
  const int failed =
      connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int cause = errno;
  close(descriptor);
  return failed == 0 || (cause != ECONNREFUSED && cause != ENOENT);
}

}  // namespace

void SocketFile::check_free(const std::string& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) return;
  if (!S_ISSOCK(status.st_mode)) {
    throw usage_error(fmt::format(
        "cannot bind endpoint 'ipc://{}': that is no socket; expected a path that is free", path));
  }
  if (in_use(path)) {
    throw temporary_error(fmt::format(
        "cannot bind endpoint 'ipc://{}': it is in use; expected a path that is free", path));
  }
}

void SocketFile::own(const std::string& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return;
  path_ = path;
  device_ = status.st_dev;
  inode_ = status.st_ino;
}

SocketFile::~SocketFile() {
  if (path_.empty()) return;
  // Another may have taken the place since.
  struct stat status {};
  if (lstat(path_.c_str(), &status) != 0) return;
  if (status.st_dev == device_ && status.st_ino == inode_) unlink(path_.c_str());
}

}  // namespace tessera
