#include "cli/texture_decoder.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "base/file.h"
#include "renderer/image/image_file.h"

namespace tessera {
namespace {

DecodedTexture as_texture(TextureImage picture) {
  return {.width = picture.width,
          .height = picture.height,
          .channels = picture.channels,
          .bits = picture.bits,
          .texels = std::move(picture.texels)};
}

/// A file in memory, for decoders that read files only.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : file_(memfd_create("picture", MFD_CLOEXEC)) {
    while (file_ >= 0 && !bytes.empty()) {
      const ssize_t done = ::write(file_, bytes.data(), bytes.size());
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) break;
      bytes.remove_prefix(static_cast<size_t>(done));
    }
    if (file_ >= 0 && bytes.empty()) return;
    const std::string why = std::strerror(errno);
    if (file_ >= 0) ::close(file_);
    throw render_error(why);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(file_); }

  std::string path() const { return fmt::format("/proc/{}/fd/{}", ::getpid(), file_); }

 private:
  int file_;
};

}  // namespace

DecodedTexture decode_texture(const std::string& path) {
  check_input_file(path, UINT64_MAX);
  return as_texture(read_texture_image(path));
}

DecodedTexture decode_texture_bytes(std::string_view bytes, const std::string& name) {
  const MemoryFile file(bytes);
  try {
    return as_texture(read_texture_image(file.path()));
  } catch (const Error& problem) {
    std::string why = problem.what();
    if (why.starts_with(file.path())) why.replace(0, file.path().size(), name);
    throw scene_error(why);
  }
}

}  // namespace tessera
