#include "studio/files/replace_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <vector>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/folder.h"
#include "base/open_file.h"
#include "studio/files/new_file.h"

namespace tessera {
namespace {

/// Larger ones are not copied to be written where they lie.
constexpr off_t kMostCopied = off_t{1} << 30;

Error not_written(const ReplacedFile& file, std::string_view why) {
  return render_error(fmt::format("'{}' cannot be written: {}", file.shown, why));
}

OwnedDescriptor copy_of(int descriptor) {
  const SpareDescriptors spare;
  return OwnedDescriptor(::fcntl(descriptor, F_DUPFD_CLOEXEC, 0));
}

bool is_unchanged(const ReplacedFile& file) {
  struct stat now;
  if (::fstatat(file.folder, file.leaf.c_str(), &now, AT_SYMLINK_NOFOLLOW) != 0) return false;
  const struct stat& then = file.status;
  return now.st_dev == then.st_dev && now.st_ino == then.st_ino && now.st_size == then.st_size &&
         now.st_mtim.tv_sec == then.st_mtim.tv_sec && now.st_mtim.tv_nsec == then.st_mtim.tv_nsec;
}

/// Access lists among them; what this file system or account may not set is left out.
void copy_attributes(int from, int to) {
  std::vector<char> names(size_t{64} << 10), value(size_t{64} << 10);
  const ssize_t size = ::flistxattr(from, names.data(), names.size());
  for (ssize_t at = 0; at < size;) {
    const char* name = names.data() + at;
    const ssize_t count = ::fgetxattr(from, name, value.data(), value.size());
    if (count >= 0) ::fsetxattr(to, name, value.data(), static_cast<size_t>(count), 0);
    at += static_cast<ssize_t>(std::strlen(name)) + 1;
  }
}

/// Gives the new file what the old one had; false where this account may not.
bool copy_owner_and_mode(const ReplacedFile& old, int to) {
  struct stat made;
  if (::fstat(to, &made) != 0) return false;
  const bool is_alike = made.st_uid == old.status.st_uid && made.st_gid == old.status.st_gid;
  if (!is_alike && ::fchown(to, old.status.st_uid, old.status.st_gid) != 0) return false;
  if (::fchmod(to, old.status.st_mode & 07777) != 0) return false;
  copy_attributes(old.descriptor, to);
  return true;
}

bool overwrite(int file, std::string_view bytes) {
  const auto size = static_cast<off_t>(bytes.size());
  return write_all_at(file, 0, std::as_bytes(std::span(bytes))) && ::ftruncate(file, size) == 0 &&
         ::fsync(file) == 0;
}

/// Where a new file in its place would end hard links or change its owner.
FileVersion write_in_place(const ReplacedFile& file, std::string_view bytes) {
  if (file.status.st_size > kMostCopied) throw not_written(file, "it is too large to be copied");
  std::string before(static_cast<size_t>(file.status.st_size), '\0');
  if (!read_all_at(file.descriptor, 0, std::as_writable_bytes(std::span(before))))
    throw not_written(file, std::strerror(errno));
  struct stat status;
  const OwnedDescriptor target = open_regular(file.folder, file.leaf, O_WRONLY, status);
  if (target.get() < 0) throw not_written(file, reason_not_opened(errno));
  if (status.st_ino != file.status.st_ino) throw not_written(file, "it was replaced meanwhile");
  const std::string backup = fmt::format("{}.{}.backup", file.leaf.substr(0, 200), unique_name());
  NewFile copy(copy_of(file.folder), backup, file.shown, 0600);
  copy.append(before);
  copy.finish();
  // So that a full disk is known before anything is written.
  const bool has_space =
      bytes.empty() ||
      ::fallocate(target.get(), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes.size())) == 0 ||
      errno == EOPNOTSUPP || errno == ENOSYS;
  const bool is_written = has_space && overwrite(target.get(), bytes);
  const std::string why = is_written ? "" : std::strerror(errno);
  if (has_space && !is_written && !overwrite(target.get(), before))
    throw not_written(file, fmt::format("{}; what it was is in '{}'", why, backup));
  ::unlinkat(file.folder, backup.c_str(), 0);
  if (!is_written) throw not_written(file, why);
  return version_of(target.get(), bytes);
}

}  // namespace

OwnedDescriptor open_regular(int folder, const std::string& leaf, int flags, struct stat& status) {
  if (::fstatat(folder, leaf.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return OwnedDescriptor();
  const auto is_regular = [&] { return S_ISREG(status.st_mode); };
  if (S_ISLNK(status.st_mode)) return errno = ELOOP, OwnedDescriptor();
  if (!is_regular()) return errno = kNotRegular, OwnedDescriptor();
  const SpareDescriptors spare;
  OwnedDescriptor file(
      ::openat(folder, leaf.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (file.get() < 0) return file;
  if (::fstat(file.get(), &status) != 0) return OwnedDescriptor();
  if (!is_regular()) return errno = kNotRegular, OwnedDescriptor();
  return file;
}

std::string reason_not_opened(int error) {
  if (error == kNotRegular) return "it is no regular file";
  if (error == ELOOP) return "it became a link";
  return std::strerror(error);
}

FileVersion version_of(int file, std::string_view bytes) {
  struct stat status;
  const bool is_known = ::fstat(file, &status) == 0;
  return {Digest::of(bytes), is_known ? FileStamp::of(status) : FileStamp{}};
}

std::optional<FileVersion> replace_file(const ReplacedFile& file, std::string_view bytes,
                                        bool keeps_others) {
  if (file.status.st_nlink > 1) return write_in_place(file, bytes);
  NewFile made(copy_of(file.folder), file.leaf, file.shown, 0600);
  made.append(bytes);
  if (!copy_owner_and_mode(file, made.descriptor())) return write_in_place(file, bytes);
  if (keeps_others && !is_unchanged(file)) return std::nullopt;
  made.finish_over();
  return version_of(made.descriptor(), bytes);
}

}  // namespace tessera
