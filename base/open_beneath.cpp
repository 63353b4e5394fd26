#include "base/open_beneath.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "base/descriptors.h"

namespace tessera {

OwnedDescriptor open_beneath(int root, const std::string& path, int flags) {
  struct open_how how = {};
  how.flags = static_cast<uint64_t>(flags | O_CLOEXEC);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
  const char* name = path.empty() ? "." : path.c_str();
  constexpr int kMostTries = 100;  // it fails with EAGAIN while folders are renamed
  long opened = -1;
  for (int i = 0; i < kMostTries && opened < 0; ++i) {
    const SpareDescriptors spare;
    opened = ::syscall(SYS_openat2, root, name, &how, sizeof how);
    if (opened < 0 && errno != EAGAIN && errno != EINTR) break;
  }
  if (opened < 0 && (errno == ENOSYS || errno == EPERM))
    return open_beneath_by_steps(root, path, flags);
  return OwnedDescriptor(static_cast<int>(opened));
}

OwnedDescriptor open_beneath_by_steps(int root, const std::string& path, int flags) {
  const SpareDescriptors spare;
  OwnedDescriptor folder;
  size_t at = 0;
  for (size_t end; (end = path.find('/', at)) != std::string::npos; at = end + 1) {
    const std::string part = path.substr(at, end - at);
    if (part == "..") return errno = EXDEV, OwnedDescriptor();
    const int from = folder.get() < 0 ? root : folder.get();
    folder = OwnedDescriptor(
        ::openat(from, part.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (folder.get() < 0) return OwnedDescriptor();
  }
  const std::string leaf = path.empty() ? "." : path.substr(at);
  if (leaf == ".." || path.starts_with('/')) return errno = EXDEV, OwnedDescriptor();
  const int from = folder.get() < 0 ? root : folder.get();
  OwnedDescriptor opened(::openat(from, leaf.c_str(), flags | O_NOFOLLOW | O_CLOEXEC));
  struct stat status;
  const bool is_link = opened.get() >= 0 && ::fstat(opened.get(), &status) == 0 &&
                       S_ISLNK(status.st_mode);  // O_PATH opens them
  return is_link ? (errno = ELOOP, OwnedDescriptor()) : std::move(opened);
}

}  // namespace tessera
