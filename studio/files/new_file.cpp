#include "studio/files/new_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <utility>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/folder.h"
#include "base/open_file.h"

namespace tessera {

namespace {

constexpr std::string_view kPrefix = ".tessera-", kSuffix = ".part";

/// Whether nobody removed the file between its creation and its being locked.
bool is_there_still(int file) {
  struct stat status;
  return ::fstat(file, &status) != 0 || status.st_nlink > 0;
}

}  // namespace

NewFile::NewFile(OwnedDescriptor folder, std::string name, std::string shown, mode_t mode)
    : folder_(std::move(folder)), name_(std::move(name)), shown_(std::move(shown)) {
  const SpareDescriptors spare;
  do {
    unfinished_ = fmt::format("{}{}{}", kPrefix, unique_name(), kSuffix);
    file_ = OwnedDescriptor(::openat(folder_.get(), unfinished_.c_str(),
                                     O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
    if (file_.get() < 0) {
      unfinished_.clear();
      fail();
    }
    // Who holds the lock is still at it; some file systems have none.
    ::flock(file_.get(), LOCK_EX | LOCK_NB);
  } while (!is_there_still(file_.get()));
}

bool NewFile::remove_unfinished(int folder, const std::string& name) {
  if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) return false;
  struct stat status;
  const SpareDescriptors spare;
  const OwnedDescriptor file(
      ::openat(folder, name.c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC));
  return file.get() >= 0 && ::fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode) &&
         ::flock(file.get(), LOCK_EX | LOCK_NB) == 0 && ::unlinkat(folder, name.c_str(), 0) == 0;
}

NewFile::NewFile(NewFile&& other) noexcept
    : folder_(std::move(other.folder_)),
      file_(std::move(other.file_)),
      name_(std::move(other.name_)),
      shown_(std::move(other.shown_)),
      unfinished_(std::exchange(other.unfinished_, {})) {}

NewFile::~NewFile() {
  if (!unfinished_.empty()) ::unlinkat(folder_.get(), unfinished_.c_str(), 0);
}

void NewFile::append(std::string_view bytes) {
  if (!write_all(file_.get(), std::as_bytes(std::span(bytes)))) fail();
}

void NewFile::sync() {
  if (::fsync(file_.get()) != 0) fail();
}

void NewFile::finish() {
  sync();
  const char *from = unfinished_.c_str(), *to = name_.c_str();
  int done = ::renameat2(folder_.get(), from, folder_.get(), to, RENAME_NOREPLACE);
  if (done != 0 && (errno == EINVAL || errno == ENOSYS)) {  // not on every file system
    done = ::linkat(folder_.get(), from, folder_.get(), to, 0);
    if (done == 0) ::unlinkat(folder_.get(), from, 0);
  }
  if (done != 0) fail();
  unfinished_.clear();
  ::fsync(folder_.get());  // where the file system can do that for a folder
}

void NewFile::finish_over() {
  sync();
  if (::renameat(folder_.get(), unfinished_.c_str(), folder_.get(), name_.c_str()) != 0) fail();
  unfinished_.clear();
  ::fsync(folder_.get());
}

void NewFile::fail() const {
  throw render_error(fmt::format("'{}' cannot be written: {}", shown_, std::strerror(errno)));
}

}  // namespace tessera
