#include "base/open_input.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "base/descriptors.h"
#include "base/open_beneath.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// A pipe that was put in a file's place makes nobody wait.
constexpr int kToRead = O_RDONLY | O_NONBLOCK | O_CLOEXEC;

OwnedDescriptor open_any(const std::string& path, int flags) {
  const SpareDescriptors spare;
  return OwnedDescriptor(::open(path.c_str(), flags));
}

/// Whether a part of the path begins with '.'.
bool is_hidden(const fs::path& path) {
  return std::ranges::any_of(
      path, [](const fs::path& part) { return part != "." && part.native().starts_with('.'); });
}

}  // namespace

InputRoots::InputRoots(std::vector<fs::path> roots) : roots_(std::move(roots)) { current_ = this; }

InputRoots::~InputRoots() { current_ = outer_; }

OwnedDescriptor InputRoots::open(const std::string& path) const {
  std::error_code failure;
  const fs::path whole = fs::weakly_canonical(fs::absolute(path, failure), failure);
  if (failure) return errno = failure.value(), OwnedDescriptor();
  for (const fs::path& root : roots_) {
    const fs::path inside = whole.lexically_relative(root);
    if (inside.empty() || *inside.begin() == "..") continue;
    if (is_hidden(inside)) return errno = EACCES, OwnedDescriptor();
    const OwnedDescriptor folder = open_any(root.string(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder.get() < 0) return OwnedDescriptor();
    return open_beneath(folder.get(), inside.string(), kToRead);
  }
  return errno = EXDEV, OwnedDescriptor();
}

OwnedDescriptor open_input(const std::string& path) {
  const InputRoots* const roots = InputRoots::of_this_thread();
  OwnedDescriptor file = roots ? roots->open(path) : open_any(path, kToRead);
  struct stat status;
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) return OwnedDescriptor();
  if (!S_ISREG(status.st_mode)) return errno = EINVAL, OwnedDescriptor();
  return file;
}

InputFile open_input_file(const std::string& path) {
  OwnedDescriptor file = open_input(path);
  if (file.get() < 0) return nullptr;
  InputFile opened(::fdopen(file.get(), "rb"));
  if (opened) file.release();
  return opened;
}

}  // namespace tessera
