#include "studio/files/user_folder.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "base/error.h"

namespace tessera {

namespace fs = std::filesystem;

fs::path user_folder(const char* variable, const char* fallback) {
  // The specification has relative ones ignored.
  const char* named = std::getenv(variable);
  if (named != nullptr && *named == '/') return fs::path(named) / "tessera";
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home != '/') return {};
  return fs::path(home) / fallback / "tessera";
}

void make_private_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder.parent_path(), failure);
  if (::mkdir(folder.c_str(), 0700) == 0 || (errno == EEXIST && fs::is_directory(folder, failure)))
    return;
  throw render_error(fmt::format("'{}' cannot be made: {}", folder.string(), std::strerror(errno)));
}

}  // namespace tessera
