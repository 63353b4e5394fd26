#pragma once

#include <sys/types.h>

#include <span>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "base/owned_descriptor.h"
#include "base/program_folder.h"

namespace tessera {

struct LocalWorkerOptions {
  int count = 4;
  int threads = 1;                       ///< of each worker
  int nice = 0;                          ///< levels below this process's priority, as nice(1)
  std::string program = program_path();  ///< what to run
  /// Arguments after "worker --connect ENDPOINT --threads N --parent PID --arena 0 --nice N".
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
  /// Kills one of ours that never said hello. The second time that this befalls all of them without
  /// progress in between, replace() throws.
  void kill_silent(pid_t process);
  /// The processes that ended since the last call.
  std::vector<EndedProcess> collect_ended();
  /// Starts one in place of each. Throws render_error, with how the last one ended, when
  /// replacements failed too often. After that it retries after pauses of 1 to 10 s, and throws on
  /// each failure. Called also when none has ended. Takes microseconds.
  void replace(std::span<const EndedProcess> ended, Time now);
  /// Waits up to `grace` for them to end by themselves (they were sent Shutdown), then sends
  /// SIGTERM, then SIGKILL; returns when none is left, after at most about 2 * grace.
  void stop(Time grace);
  std::vector<pid_t> processes() const { return running_; }

 private:
  void spawn();
  int most_replacements() const;
  /// Starts those that are missing.
  void fill_up(Time now);
  void postpone(Time now);

  LocalWorkerOptions options_;
  std::string folder_;
  int folder_lock_ = -1;  ///< a descriptor: as long as it is open, nobody takes folder_ for stale
  std::string endpoint_;
  OwnedDescriptor arena_;  ///< of SharedArena, in which they share what they build
  std::vector<pid_t> running_;
  size_t wanted_ = 0;  ///< that many should run
  int replacements_left_ = 0;
  Time pause_{};             ///< the last one after vain starts
  Time next_start_{};        ///< none before
  bool are_silent_ = false;  ///< the last one that was killed never said hello
};

}  // namespace tessera
