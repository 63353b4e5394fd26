#include "cli/output_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.h"

namespace tessera {

void check_output_file(std::string_view option, const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const auto refuse = [&](std::string_view why) {
    throw usage_error(fmt::format("{}: '{}' cannot be written: {}", option, path.string(), why));
  };
  if (path.filename().empty() || std::filesystem::is_directory(path, ignored)) {
    refuse("it is a folder");
  }
  if (!std::filesystem::is_directory(folder, ignored)) {
    refuse(fmt::format("there is no folder '{}'", folder.string()));
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) refuse(std::strerror(errno));
  if (std::filesystem::exists(path, ignored) && access(path.c_str(), W_OK) != 0) {
    refuse(std::strerror(errno));
  }
}

}  // namespace tessera
