#include "base/process_usage.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace tessera {

ProcessUsage process_usage() {
  ProcessUsage usage;
  std::ifstream file("/proc/self/statm");
  uint64_t size = 0, resident = 0;
  if (file >> size >> resident) {
    usage.resident_bytes = resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  }
  rusage used{};
  if (getrusage(RUSAGE_SELF, &used) == 0) {
    const auto seconds = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
    };
    usage.cpu_seconds = seconds(used.ru_utime) + seconds(used.ru_stime);
  }
  std::error_code error;
  const std::filesystem::directory_iterator files("/proc/self/fd", error);
  if (!error) usage.open_files = static_cast<uint64_t>(std::distance(begin(files), end(files)));
  return usage;
}

namespace {

/// The word or number behind `name` in a file of lines "NAME VALUE".
std::string value_in(const std::filesystem::path& path, const std::string& name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string word, value;
    if (words >> word >> value && word == name) return value;
  }
  return "";
}

uint64_t number_of(const std::string& text) {
  uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

std::string word_in(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string word;
  file >> word;
  return word;
}

}  // namespace

double cpu_seconds_of(int process) {
  const std::string text = [process] {
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    return std::string(std::istreambuf_iterator<char>(file), {});
  }();
  // The name before it, in brackets, may hold anything.
  const size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream fields(text.substr(name_end + 1));
  std::string skipped;
  constexpr int kBeforeTimes = 11;
  for (int i = 0; i < kBeforeTimes; ++i) fields >> skipped;
  uint64_t user = 0, system = 0;
  if (!(fields >> user >> system)) return 0;
  return static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

MachineUsage machine_usage() {
  MachineUsage usage;
  std::ifstream file("/proc/stat");
  std::string name;
  file >> name;
  // user, nice, system, idle, iowait, irq, softirq, steal
  constexpr int kFields = 8, kIdle = 3, kWaiting = 4;
  const auto ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  uint64_t count = 0;
  for (int i = 0; i < kFields && file >> count; ++i) {
    const double seconds = static_cast<double>(count) / ticks;
    usage.all_seconds += seconds;
    if (i != kIdle && i != kWaiting) usage.busy_seconds += seconds;
  }
  constexpr uint64_t kKibi = 1024;
  usage.memory_bytes = kKibi * number_of(value_in("/proc/meminfo", "MemTotal:"));
  const uint64_t available = kKibi * number_of(value_in("/proc/meminfo", "MemAvailable:"));
  usage.used_bytes = usage.memory_bytes - std::min(available, usage.memory_bytes);
  return usage;
}

uint64_t memory_kills() {
  // "0::/GROUP" in version 2 of cgroups, "5:memory:/GROUP" in version 1, whose limit is a number in
  // any case.
  constexpr uint64_t kNoLimit = uint64_t{1} << 60;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const size_t group = line.find(":/");
    if (group == std::string::npos) continue;
    const std::string name = line.substr(group + 2), kind = line.substr(0, group);
    if (kind == "0:") {
      const auto folder = std::filesystem::path("/sys/fs/cgroup") / name;
      const uint64_t limit = number_of(word_in(folder / "memory.max"));
      if (limit > 0) return number_of(value_in(folder / "memory.events", "oom_kill"));
    } else if (kind.ends_with(":memory")) {
      const auto folder = std::filesystem::path("/sys/fs/cgroup/memory") / name;
      const uint64_t limit = number_of(word_in(folder / "memory.limit_in_bytes"));
      if (limit > 0 && limit < kNoLimit) {
        return number_of(value_in(folder / "memory.oom_control", "oom_kill"));
      }
    }
  }
  return 0;
}

std::chrono::nanoseconds thread_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace tessera
