#include "base/descriptors.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <filesystem>
#include <iterator>
#include <system_error>

#include "base/error.h"

namespace tessera {

void check_room_for_descriptors(int count) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  std::error_code error;
  const std::filesystem::directory_iterator open("/proc/self/fd", error);
  // To list them takes one.
  const bool none_left = error == std::errc::too_many_files_open;
  if (error && !none_left) return;
  const auto used =
      none_left ? limit.rlim_cur : static_cast<rlim_t>(std::distance(begin(open), {}));
  if (used + static_cast<rlim_t>(count) <= limit.rlim_cur) return;
  throw render_error(
      fmt::format("{} of {} file descriptors are in use; expected {} left: raise the limit (ulimit "
                  "-n)",
                  used, limit.rlim_cur, count));
}

}  // namespace tessera
