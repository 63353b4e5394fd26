#include "bench/studio/studio_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <utility>

#include "base/error.h"
#include "base/folder.h"
#include "base/owned_descriptor.h"
#include "base/process.h"
#include "base/program_folder.h"

namespace tessera {
namespace {

constexpr int kMillisecondsToStart = 30'000;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// What comes until the end of the line.
std::string read_line(int descriptor) {
  std::string line;
  char sign = 0;
  for (pollfd ready{descriptor, POLLIN, 0};
       poll(&ready, 1, kMillisecondsToStart) == 1 && read(descriptor, &sign, 1) == 1;) {
    if (sign == '\n') break;
    line += sign;
  }
  return line;
}

}  // namespace

StudioProcess::StudioProcess(const std::filesystem::path& folder, std::function<void()> check)
    : check_(std::move(check)) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw render_error("no pipe can be made");
  const OwnedDescriptor ours(ends[0]);
  {
    const OwnedDescriptor theirs(ends[1]);
    process_ =
        start_process(program_path(),
                      {"tessera", "studio", folder.string(), "--http", "127.0.0.1:0", "--no-open"},
                      {.standard_output = theirs.get()});
  }
  const std::string line = read_line(ours.get());
  std::smatch found;
  if (!std::regex_match(line, found, std::regex("studio at http://([^/]+)/#token=(\\w+)"))) {
    kill(process_, SIGKILL);
    wait_for_process(process_);
    throw render_error(fmt::format("the studio said '{}'; expected its address", line));
  }
  address_ = found[1];
  token_ = found[2];
}

StudioProcess::~StudioProcess() {
  kill(process_, SIGTERM);
  wait_for_process(process_);
}

std::vector<int> StudioProcess::workers() const {
  const std::string parent = fmt::format("PPid:\t{}\n", process_);
  std::vector<int> found;
  for (const auto& entry : entries_in("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (text_of(entry.path() / "status").find(parent) == std::string::npos) continue;
    if (text_of(entry.path() / "cmdline").find(std::string("\0worker\0", 8)) != std::string::npos) {
      found.push_back(std::stoi(name));
    }
  }
  return found;
}

uint64_t nanoseconds_of(int process) {
  uint64_t sum = 0;
  for (const auto& task : entries_in(fmt::format("/proc/{}/task", process))) {
    uint64_t ran = 0;
    std::ifstream(task.path() / "schedstat") >> ran;
    sum += ran;
  }
  return sum;
}

uint64_t resident_bytes_of(int process) {
  uint64_t all = 0, resident = 0;
  std::ifstream(fmt::format("/proc/{}/statm", process)) >> all >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace tessera
