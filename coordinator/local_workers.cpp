#include "coordinator/local_workers.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <thread>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/folder.h"
#include "base/log.h"
#include "base/open_file.h"
#include "base/process.h"
#include "base/shared_arena.h"

namespace tessera {
namespace {

constexpr int kVainReplacements = 8;
constexpr Time kLook = std::chrono::milliseconds(1);

constexpr std::string_view kFolderName = "tessera-farm-";

/// Holds `folder` against removal until it is closed; -1 where another holds it or it is gone.
int hold(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0) return -1;
  struct stat status {};
  if (hold_alone(descriptor, status) && status.st_uid == geteuid()) return descriptor;
  close(descriptor);
  return -1;
}

/// Removes the folders of processes of this user that could not do so themselves.
void remove_stale_folders(const std::filesystem::path& parent) {
  for (const auto& entry : entries_in(parent)) {
    if (!entry.path().filename().string().starts_with(kFolderName)) continue;
    const int descriptor = hold(entry.path().string());
    if (descriptor < 0) continue;
    std::error_code ignored;
    std::filesystem::remove_all(entry.path(), ignored);
    close(descriptor);
  }
}

/// The folder, and the descriptor that holds it.
std::pair<std::string, int> make_private_folder() {
  std::error_code error;
  std::filesystem::path parent = std::filesystem::temp_directory_path(error);
  // A socket's path has to be short.
  constexpr size_t kLongestParent = 64;
  if (error || parent.native().size() > kLongestParent) parent = "/tmp";
  remove_stale_folders(parent);
  // Another process may take it for a stale one before it is held.
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::string pattern = (parent / (std::string(kFolderName) + "XXXXXX")).string();
    if (!mkdtemp(pattern.data())) {
      throw render_error(
          fmt::format("cannot make a folder like '{}': {}", pattern, std::strerror(errno)));
    }
    if (const int descriptor = hold(pattern); descriptor >= 0) return {pattern, descriptor};
    rmdir(pattern.c_str());
  }
  throw render_error(fmt::format("cannot lock a folder in '{}'", parent.string()));
}

/// The transport cannot stand to run out of descriptors: whether there are enough is found out
/// before. Raises this process's own limit as far as it may.
void provide_descriptors(int workers) {
  constexpr rlim_t kPerWorker = 2;  // control and bulk
  constexpr rlim_t kOurOwn = 40;    // the transport's, standard streams, files of the scene
  const rlim_t needed = kOurOwn + kPerWorker * static_cast<rlim_t>(std::max(workers, 0));
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= needed) return;
  if (limit.rlim_max < needed) {
    throw render_error(
        fmt::format("at most {} files may be open; expected at least {} for {} workers (ulimit -n)",
                    limit.rlim_max, needed, workers));
  }
  limit.rlim_cur = needed;
  if (setrlimit(RLIMIT_NOFILE, &limit) != 0) {
    throw render_error(fmt::format("cannot raise the number of open files to {}: {}", needed,
                                   std::strerror(errno)));
  }
}

EndedProcess describe(pid_t pid, int status) {
  EndedProcess ended{pid, true, fmt::format("process {} ended with {}", pid, how_it_ended(status))};
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    ended.crashed = signal != SIGKILL && signal != SIGTERM && signal != SIGINT && signal != SIGHUP;
  } else {
    ended.crashed = WEXITSTATUS(status) != 0;
  }
  return ended;
}

}  // namespace

LocalWorkers::LocalWorkers(LocalWorkerOptions options)
    : options_(std::move(options)), arena_(SharedArena::create()) {
  provide_descriptors(options_.count);
  std::tie(folder_, folder_lock_) = make_private_folder();
  endpoint_ = "ipc://" + folder_ + "/farm";
  note_progress();
}

LocalWorkers::~LocalWorkers() {
  stop(Time{0});
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
  close(folder_lock_);
}

void LocalWorkers::note_progress() {
  replacements_left_ = most_replacements();
  are_silent_ = false;
  pause_ = next_start_ = Time{};
}

int LocalWorkers::most_replacements() const {
  return std::max(kVainReplacements, 4 * options_.count);
}

void LocalWorkers::start() {
  wanted_ = static_cast<size_t>(std::max(options_.count, 0));
  while (running_.size() < wanted_) spawn();
}

void LocalWorkers::spawn() {
  std::vector<std::string> arguments = {"tessera",   "worker",
                                        "--connect", endpoint_,
                                        "--threads", std::to_string(options_.threads),
                                        "--parent",  std::to_string(getpid()),
                                        "--arena",   "0",
                                        "--nice",    std::to_string(options_.nice)};
  arguments.insert(arguments.end(), options_.extra_arguments.begin(),
                   options_.extra_arguments.end());
  running_.push_back(
      start_process(options_.program, std::move(arguments), {.standard_input = arena_.get()}));
}

std::vector<EndedProcess> LocalWorkers::collect_ended() {
  std::vector<EndedProcess> ended;
  std::erase_if(running_, [&](pid_t pid) {
    int status = 0;
    const pid_t changed = waitpid(pid, &status, WNOHANG);
    if (changed == pid) {
      ended.push_back(describe(pid, status));
      return true;
    }
    // Where SIGCHLD is ignored, the kernel forgets who ends.
    if (changed >= 0 || errno != ECHILD) return false;
    ended.push_back({pid, false, fmt::format("process {} ended, nobody knows how", pid)});
    return true;
  });
  return ended;
}

void LocalWorkers::replace(std::span<const EndedProcess> ended, Time now) {
  for (const EndedProcess& process : ended) {
    if (--replacements_left_ < 0) {
      postpone(now);
      throw are_silent_
          ? render_error(
                fmt::format("worker processes say nothing after they are started; expected '{}' to "
                            "be the program tessera",
                            options_.program))
          : render_error(fmt::format("worker processes end as soon as they are started; expected "
                                     "them to work; the last, {}",
                                     process.how));
    }
    spdlog::warn("worker {}; starting another", process.how);
  }
  fill_up(now);
}

void LocalWorkers::fill_up(Time now) {
  if (running_.size() >= wanted_ || now < next_start_) return;
  try {
    while (running_.size() < wanted_) spawn();
  } catch (const Error&) {
    postpone(now);
    throw;
  }
}

void LocalWorkers::postpone(Time now) {
  constexpr Time kShortestPause = std::chrono::seconds(1), kLongestPause = std::chrono::seconds(10);
  pause_ = std::clamp(2 * pause_, kShortestPause, kLongestPause);
  next_start_ = now + pause_;
}

void LocalWorkers::kill_stuck(pid_t process) {
  if (std::find(running_.begin(), running_.end(), process) == running_.end()) return;
  spdlog::warn("worker process {} is stuck and is ended", process);
  kill(process, SIGKILL);
}

void LocalWorkers::kill_silent(pid_t process) {
  // Each was waited for long, so that fewer of these are enough to give up.
  constexpr int kMostRounds = 2;
  replacements_left_ -= most_replacements() / (kMostRounds * std::max(options_.count, 1));
  are_silent_ = true;
  kill_stuck(process);
}

void LocalWorkers::stop(Time grace) {
  wanted_ = 0;
  for (const int signal : {0, SIGTERM, SIGKILL}) {
    if (signal != 0) {
      for (const pid_t pid : running_) kill(pid, signal);
    }
    const Time deadline = monotonic_now() + grace;
    while (collect_ended(), !running_.empty()) {
      // Nothing survives the last signal, so that is waited for.
      if (signal != SIGKILL && monotonic_now() >= deadline) break;
      std::this_thread::sleep_for(kLook);
    }
  }
}

}  // namespace tessera
