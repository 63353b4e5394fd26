#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "base/monotonic.h"
#include "base/owned_descriptor.h"
#include "base/program_folder.h"

namespace tessera {

struct LocalWorkerOptions {
  int count = 4;
  int threads = 1;                       ///< of each worker
  std::string program = program_path();  ///< what to run
  /// Arguments after "worker --connect ENDPOINT --threads N --parent PID --arena 0".
  std::vector<std::string> extra_arguments;
};

/// A worker process that ended.
struct EndedProcess {
  pid_t pid = 0;
  /// It crashed by its own doing (a signal such as SIGSEGV, or an exit code other than 0), as
  /// opposed to being killed from outside.
  bool crashed = false;
  std::string how;  ///< "process 12 ended with signal 9 (KILL)"
};

/// Worker processes on this machine, the private folder of their socket and the memory they share.
/// They die with the thread that started them (PR_SET_PDEATHSIG), so start and replace them from
/// one that lives as long as they should. Not thread-safe.
class LocalWorkers {
 public:
  /// Makes the folder, and removes those that killed processes left; throws render_error if it
  /// cannot, or if this process may not open enough files for so many workers.
  explicit LocalWorkers(LocalWorkerOptions options);
  /// Ends what still runs, as stop() does, and removes the folder.
  ~LocalWorkers();
  LocalWorkers(const LocalWorkers&) = delete;
  LocalWorkers& operator=(const LocalWorkers&) = delete;

  /// ipc://... inside the private folder: bind the server there before start().
  const std::string& endpoint() const { return endpoint_; }
  /// Starts them all and returns at once. Throws render_error if the program cannot be started.
  void start();
  /// The workers do what they should: earlier deaths no longer count.
  void note_progress();
  /// Kills one of ours.
  void kill_stuck(pid_t process);
  /// Collects the processes that ended since the last call, and starts one in place of each. Throws
  /// render_error, with how the last ones ended, when that was in vain too often. Takes
  /// microseconds.
  std::vector<EndedProcess> replace_ended();
  /// Waits up to `grace` for them to end by themselves (they were sent Shutdown), then sends
  /// SIGTERM, then SIGKILL; returns when none is left, after at most about 2 * grace.
  void stop(Time grace);
  std::vector<pid_t> processes() const { return running_; }

 private:
  void spawn();
  std::vector<EndedProcess> collect();

  LocalWorkerOptions options_;
  std::string folder_;
  int folder_lock_ = -1;  ///< a descriptor: as long as it is open, nobody takes folder_ for stale
  std::string endpoint_;
  OwnedDescriptor arena_;  ///< of SharedArena, in which they share what they build
  std::vector<pid_t> running_;
  int replacements_left_ = 0;
};

}  // namespace tessera
