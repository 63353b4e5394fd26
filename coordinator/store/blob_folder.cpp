#include "coordinator/store/blob_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <span>
#include <utility>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/file.h"
#include "base/folder.h"
#include "base/log.h"
#include "proto/wire/blob_transfer.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr size_t kReadBytes = size_t{1} << 20;

/// Reads until `bytes` is full or the file ends. Returns how many bytes it read; negative, and
/// errno says why, where it cannot.
ssize_t read_some(int file, std::span<std::byte> bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::read(file, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return -1;
    if (count == 0) break;
    done += static_cast<size_t>(count);
  }
  return static_cast<ssize_t>(done);
}

}  // namespace

void BlobFolder::fail(const Digest& digest, const std::string& why) const {
  throw temporary_error(fmt::format("'{}' cannot be read now: {}; expected the bytes of a blob",
                                    path_of(digest).string(), why));
}

OwnedDescriptor BlobFolder::open(const Digest& digest, uint64_t& size) const {
  const SpareDescriptors spare;
  // O_NONBLOCK, as a FIFO would be waited for.
  OwnedDescriptor file(::open(path_of(digest).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0 && errno == ENOENT) return file;
  struct stat status {};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) fail(digest, std::strerror(errno));
  if (S_ISDIR(status.st_mode)) fail(digest, "it is a folder");
  if (!S_ISREG(status.st_mode)) fail(digest, "it is no regular file");
  size = static_cast<uint64_t>(status.st_size);
  return file;
}

bool BlobFolder::has(const Digest& digest) {
  if (verified_.contains(digest)) {
    struct stat status {};
    if (::stat(path_of(digest).c_str(), &status) == 0) return true;
    if (errno != ENOENT) fail(digest, std::strerror(errno));
    verified_.erase(digest);
    return false;
  }
  uint64_t size = 0;
  const OwnedDescriptor file = open(digest, size);
  if (file.get() < 0) return false;
  if (size <= kMaxBlobBytes) {
    DigestStream stream;
    std::vector<std::byte> piece(kReadBytes);
    for (;;) {
      const ssize_t count = read_some(file.get(), piece);
      if (count < 0) fail(digest, std::strerror(errno));
      if (count == 0) break;
      stream.add(std::span(piece).first(static_cast<size_t>(count)));
    }
    if (stream.finish() == digest) {
      verified_.insert(digest);
      return true;
    }
  }
  put_aside(digest);
  return false;
}

BlobData BlobFolder::find(const Digest& digest) {
  uint64_t size = 0;
  const OwnedDescriptor file = open(digest, size);
  if (file.get() < 0) return nullptr;
  if (size <= kMaxBlobBytes) try {
      std::vector<std::byte> bytes(static_cast<size_t>(size));
      const ssize_t count = read_some(file.get(), bytes);
      if (count < 0) fail(digest, std::strerror(errno));
      if (std::cmp_equal(count, size) && Digest::of(bytes) == digest) {
        verified_.insert(digest);
        return make_blob(std::move(bytes));
      }
    } catch (const std::bad_alloc&) {
      fail(digest, fmt::format("there is no memory for its {} bytes", size));
    }
  put_aside(digest);
  return nullptr;
}

void BlobFolder::put_aside(const Digest& digest) {
  const fs::path from = path_of(digest), to = from.string() + ".damaged";
  if (::rename(from.c_str(), to.c_str()) != 0 && errno != ENOENT) {
    fail(digest, fmt::format("it is damaged, and cannot be renamed: {}", std::strerror(errno)));
  }
  verified_.erase(digest);
  spdlog::warn("blob {} is damaged: kept as '{}'; whoever submits its scene is asked for it again",
               digest.hex(), to.string());
}

void BlobFolder::put(const Digest& digest, const BlobData& data) {
  if (!has(digest)) {
    const SpareDescriptors spare;
    try {
      write_output_file(path_of(digest),
                        {reinterpret_cast<const char*>(data->data()), data->size()});
    } catch (const Error& error) {
      // The bytes are right: what is wrong is the disk, or how much of it is left.
      throw temporary_error(error.what());
    }
  }
  verified_.insert(digest);
}

void BlobFolder::remove(const Digest& digest) {
  ::unlink(path_of(digest).c_str());
  verified_.erase(digest);
}

std::vector<Digest> BlobFolder::list() const {
  std::vector<Digest> digests;
  for (const auto& entry : entries_in(folder_)) {
    if (const auto digest = Digest::parse(entry.path().filename().string())) {
      digests.push_back(*digest);
    }
  }
  return digests;
}

void BlobFolder::remove_unfinished() {
  for (const auto& entry : entries_in(folder_)) {
    if (is_unfinished_output(entry.path().filename().string())) ::unlink(entry.path().c_str());
  }
}

}  // namespace tessera
