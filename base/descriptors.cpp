#include "base/descriptors.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <string>
#include <system_error>

#include "base/error.h"

namespace tessera {
namespace {

constexpr rlim_t kReserve = 64;

/// The limit is the process's, and so is what is known of it.
std::mutex limit_mutex;
rlim_t kept = 0;  ///< this many below the hard limit are not to be had outside of a scope
int scopes = 0;

void set_below_hard_limit(rlim_t distance) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max - distance;
  setrlimit(RLIMIT_NOFILE, &limit);
}

/// Open descriptors below `limit`: those opened from the reserve can lie above it.
rlim_t count_open_below(rlim_t limit, std::error_code& failure) {
  rlim_t count = 0;
  for (std::filesystem::directory_iterator it("/proc/self/fd", failure), end; !failure && it != end;
       it.increment(failure)) {
    count += std::strtoull(it->path().filename().c_str(), nullptr, 10) < limit;
  }
  return count;
}

}  // namespace

void check_room_for_descriptors(int count) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  std::error_code failure;
  // To list them takes one.
  auto used = count_open_below(limit.rlim_cur, failure);
  if (failure == std::errc::too_many_files_open) {
    used = limit.rlim_cur;
  } else if (failure) {
    return;
  }
  if (used + static_cast<rlim_t>(count) <= limit.rlim_cur) return;
  const std::lock_guard lock(limit_mutex);
  throw render_error(fmt::format(
      "{} of {} file descriptors are in use{}; expected {} left: raise the limit (ulimit -n)", used,
      limit.rlim_cur, kept > 0 ? fmt::format(", beside {} that are kept for files", kept) : "",
      count));
}

void keep_spare_descriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_max == RLIM_INFINITY) return;
  const std::lock_guard lock(limit_mutex);
  kept = std::min(kReserve, limit.rlim_max / 4);
  set_below_hard_limit(kept);
}

SpareDescriptors::SpareDescriptors() {
  const std::lock_guard lock(limit_mutex);
  if (++scopes == 1 && kept > 0) set_below_hard_limit(0);
}

SpareDescriptors::~SpareDescriptors() {
  const std::lock_guard lock(limit_mutex);
  if (--scopes == 0 && kept > 0) set_below_hard_limit(kept);
}

}  // namespace tessera
