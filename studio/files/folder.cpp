#include "studio/files/folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/file.h"
#include "base/open_beneath.h"
#include "studio/files/file_name.h"
#include "studio/files/replace_file.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

Error not_readable(const std::string& name, std::string_view why) {
  return scene_error(fmt::format("'{}' cannot be read: {}", name, why));
}

Error not_writable(const std::string& name, std::string_view why) {
  return render_error(fmt::format("'{}' cannot be written: {}", name, why));
}

Error is_taken(const std::string& name) { return not_writable(name, "there is one of that name"); }

/// Reads until the file ends or there is one byte more than `most`; false with errno.
bool read_some(int file, size_t most, std::string& bytes) {
  constexpr size_t kPiece = size_t{1} << 20;
  while (bytes.size() <= most) {
    const size_t done = bytes.size();
    bytes.resize(done + std::min(kPiece, most + 1 - done));
    ssize_t count;
    do {
      count = ::pread(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    } while (count < 0 && errno == EINTR);
    bytes.resize(done + static_cast<size_t>(std::max<ssize_t>(count, 0)));
    if (count <= 0) return count == 0;
  }
  return true;
}

}  // namespace

std::string ExistingFiles::why() const { return is_taken(first).what(); }

Folder::Folder(const fs::path& path, Access access) : access_(access) {
  std::error_code failure;
  path_ = fs::canonical(path, failure);
  if (failure) throw usage_error(fmt::format("'{}': {}", path.string(), failure.message()));
  if (!fs::is_directory(path_, failure))
    throw usage_error(fmt::format("'{}' is no folder", path.string()));
}

Folder::Place Folder::find(const std::string& name) const {
  if (const std::string fault = fault_of_name(name); !fault.empty())
    throw scene_error(fmt::format("'{}' is no name of a file here: {}", name, fault));
  const auto target = resolve_inside(path_, name);
  if (!target) throw scene_error(fmt::format("'{}' leads out of the folder, or nowhere", name));
  const fs::path relative = target->lexically_relative(path_);
  Place place{name, relative.string(), OwnedDescriptor(), relative.filename().string()};
  if (const std::string fault = fault_of_name(place.canonical); !fault.empty())
    throw scene_error(fmt::format("'{}' leads to '{}': {}", name, place.canonical, fault));
  const OwnedDescriptor root = [&] {
    const SpareDescriptors spare;
    return OwnedDescriptor(::open(path_.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  }();
  if (root.get() < 0)
    throw scene_error(fmt::format("'{}': {}", path_.string(), std::strerror(errno)));
  const std::string parent = relative.parent_path().string();
  place.folder = open_beneath(root.get(), parent, O_RDONLY | O_DIRECTORY);
  if (place.folder.get() < 0 && errno != ENOENT) throw not_readable(name, std::strerror(errno));
  return place;
}

Folder::Place Folder::find_to_write(const std::string& name) const {
  if (is_read_only()) throw not_writable(name, "everything is for reading only");
  Place place = find(name);
  if (place.folder.get() < 0) throw not_writable(name, "its folder is not there");
  return place;
}

std::string Folder::canonical(const std::string& name) const { return find(name).canonical; }

FileContent Folder::read(const std::string& name, size_t most_bytes) const {
  constexpr int kMostTries = 3;
  const Place place = find(name);
  if (place.folder.get() < 0) throw not_readable(name, std::strerror(ENOENT));
  for (int i = 1;; ++i) {
    struct stat before, after;
    const OwnedDescriptor file = open_regular(place.folder.get(), place.leaf, O_RDONLY, before);
    if (file.get() < 0) throw not_readable(name, reason_not_opened(errno));
    FileContent content;
    content.bytes.reserve(std::min<size_t>(most_bytes, static_cast<size_t>(before.st_size)) + 1);
    if (!read_some(file.get(), most_bytes, content.bytes) || ::fstat(file.get(), &after) != 0)
      throw not_readable(name, std::strerror(errno));
    const FileStamp stamp = FileStamp::of(after);
    const FileStamp start = FileStamp::of(before);
    // A program that writes it meanwhile may still be at it: what was read is no whole text.
    if ((stamp.changed != start.changed || stamp.size != start.size) && i < kMostTries) continue;
    content.is_whole = content.bytes.size() <= most_bytes;
    content.size = std::max<uint64_t>(stamp.size, content.bytes.size());
    content.bytes.resize(std::min(content.bytes.size(), most_bytes));
    content.version = {content.is_whole ? Digest::of(content.bytes) : Digest{}, stamp};
    return content;
  }
}

FileState Folder::state(const std::string& name, FileVersion& known) const {
  const Place place = find(name);
  struct stat status;
  if (place.folder.get() < 0) return FileState::deleted;
  const OwnedDescriptor file = open_regular(place.folder.get(), place.leaf, O_RDONLY, status);
  if (file.get() >= 0) return state_of(file.get(), status, known, name);
  if (errno == ENOENT) return FileState::deleted;
  if (errno == kNotRegular || errno == ELOOP) return FileState::changed;
  throw not_readable(name, reason_not_opened(errno));
}

std::string Folder::free_name(const std::string& name) const {
  if (const std::string fault = fault_of_name(name); !fault.empty())
    throw scene_error(fmt::format("'{}' is no name of a file here: {}", name, fault));
  const fs::path path(name);
  // A link that leads nowhere takes its name, too.
  const auto is_there = [this](const std::string& each) {
    std::error_code failure;
    return fs::exists(fs::symlink_status(path_ / each, failure));
  };
  std::string free = name;
  for (int i = 2; is_there(free); ++i) {
    const std::string leaf =
        fmt::format("{}-{}{}", path.stem().string(), i, path.extension().string());
    free = (path.parent_path() / leaf).generic_string();
  }
  return free;
}

Folder::Place Folder::find_free(const std::string& name) const {
  Place place = find_to_write(name);
  struct stat status;
  if (::fstatat(place.folder.get(), place.leaf.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0)
    throw is_taken(name);
  return place;
}

bool Folder::check_writable(const std::string& name) const {
  const Place place = find_to_write(name);
  struct stat status;
  const bool is_there =
      ::fstatat(place.folder.get(), place.leaf.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
  if (is_there && !S_ISREG(status.st_mode))
    throw not_writable(name, reason_not_opened(kNotRegular));
  if (::faccessat(place.folder.get(), ".", W_OK, AT_EACCESS) != 0)
    throw not_writable(name, std::strerror(errno));
  return is_there;
}

NewFile Folder::start(const std::string& name) const {
  Place place = find_free(name);
  return NewFile(std::move(place.folder), place.leaf, name);
}

FileVersion Folder::create(const std::string& name, std::string_view bytes) const {
  NewFile file = start(name);
  file.append(bytes);
  file.finish();
  return version_of(file.descriptor(), bytes);
}

SaveResult Folder::save(const std::string& name, std::string_view bytes,
                        const std::optional<FileVersion>& expected) const {
  Place place = find_to_write(name);
  struct stat status;
  const OwnedDescriptor old = open_regular(place.folder.get(), place.leaf, O_RDONLY, status);
  if (old.get() < 0 && errno == ENOENT) {
    if (expected) return {FileState::deleted, {}};
    return {FileState::same, create(name, bytes)};
  }
  if (old.get() < 0) throw not_writable(name, reason_not_opened(errno));
  // A new file could take its place all the same.
  if (::faccessat(place.folder.get(), place.leaf.c_str(), W_OK, AT_EACCESS) != 0)
    throw not_writable(name, std::strerror(errno));
  if (expected) {
    FileVersion known = *expected;
    if (state_of(old.get(), status, known, name) != FileState::same)
      return {FileState::changed, {}};
  }
  const auto saved = replace_file({place.folder.get(), place.leaf, name, old.get(), status}, bytes,
                                  expected.has_value());
  if (!saved) return {FileState::changed, {}};
  return {FileState::same, *saved};
}

void Folder::make_folder(const std::string& name) const {
  const Place place = find_to_write(name);
  if (::mkdirat(place.folder.get(), place.leaf.c_str(), 0777) != 0)
    throw not_writable(name, std::strerror(errno));
  ::fsync(place.folder.get());
}

}  // namespace tessera
