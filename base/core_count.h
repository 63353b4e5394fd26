#pragma once

#include <sched.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <thread>

namespace tessera {

namespace detail {

/// The quota of one group, in whole cores; nothing where it sets none, or there is no such group.
inline std::optional<int> quota_of_group(const std::filesystem::path& group, bool is_version_2) {
  // Microseconds in each period: "max" or -1 is no limit, and no number here.
  int64_t quota = 0, period = 0;
  if (is_version_2) {
    std::ifstream(group / "cpu.max") >> quota >> period;
  } else {
    std::ifstream(group / "cpu.cfs_quota_us") >> quota;
    std::ifstream(group / "cpu.cfs_period_us") >> period;
  }
  if (quota <= 0 || period <= 0) return std::nullopt;
  const int64_t cores = quota / period + (quota % period != 0 ? 1 : 0);
  return static_cast<int>(std::min<int64_t>(cores, std::numeric_limits<int>::max()));
}

/// The folder below `root` whose groups govern the processors, by the controllers of a line
/// "ID:CONTROLLERS:/GROUP"; nothing where they are others.
inline std::optional<std::filesystem::path> hierarchy_of(const std::string& controllers,
                                                         const std::filesystem::path& root) {
  if (controllers.empty()) return root;
  return ("," + controllers + ",").find(",cpu,") != std::string::npos ? std::optional(root / "cpu")
                                                                      : std::nullopt;
}

}  // namespace detail

/// How many cores' time the control groups (cgroups) of this process allow it, rounded up; nothing
/// where none sets a limit. A group may take no more than any group around it, so the smallest
/// quota of all levels counts: of version 2 `cpu.max`, of version 1 `cpu.cfs_quota_us`.
/// `membership` is laid out as /proc/self/cgroup is, `root` as /sys/fs/cgroup.
inline std::optional<int> cpu_quota(const std::filesystem::path& membership = "/proc/self/cgroup",
                                    const std::filesystem::path& root = "/sys/fs/cgroup") {
  std::optional<int> least;
  std::ifstream lines(membership);
  for (std::string line; std::getline(lines, line);) {
    const size_t controllers = line.find(':') + 1, group = line.find(":/", controllers - 1);
    if (controllers == 0 || group == std::string::npos || group < controllers) continue;
    const std::string names = line.substr(controllers, group - controllers);
    const auto top = detail::hierarchy_of(names, root);
    if (!top) continue;
    // Of a container the groups outside of it are not there, and its own one is at the top.
    std::filesystem::path level = line.substr(group + 2);
    while (true) {
      if (const auto quota = detail::quota_of_group(*top / level, names.empty()))
        least = std::min(least.value_or(*quota), *quota);
      if (level.empty()) break;
      level = level.parent_path();
    }
  }
  return least;
}

/// How many threads can run at once here, as far as is known: on the cores that this process may
/// use (sched_setaffinity, cpusets), and no more than cpu_quota() was at the first call. At
/// least 1. A header alone has it, so that the image codec loads no library for it.
inline int core_count() {
  static const int quota = cpu_quota().value_or(std::numeric_limits<int>::max());
  cpu_set_t allowed;
  // Of more than 1,024 it tells by failing.
  const int cores = sched_getaffinity(0, sizeof allowed, &allowed) == 0
                        ? CPU_COUNT(&allowed)
                        : static_cast<int>(std::thread::hardware_concurrency());
  return std::max(1, std::min(cores, quota));
}

}  // namespace tessera
