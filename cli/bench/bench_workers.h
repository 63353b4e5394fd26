#pragma once

#include <signal.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "base/process.h"
#include "base/program_folder.h"

namespace tessera {

/// Worker processes of one thread each over TCP, that are gone with this object.
class BenchWorkers {
 public:
  BenchWorkers(const std::string& endpoint, int count) {
    for (int i = 0; i < count; ++i) {
      pids_.push_back(start_process(program_path(),
                                    {program_path(), "worker", "--connect", endpoint, "--threads",
                                     "1", "--quiet", "--parent", std::to_string(getpid())},
                                    {.discards_output = true}));
    }
  }
  ~BenchWorkers() {
    for (const pid_t pid : pids_) kill(pid, SIGKILL);
    for (const pid_t pid : pids_) wait_for_process(pid);
  }
  BenchWorkers(const BenchWorkers&) = delete;
  BenchWorkers& operator=(const BenchWorkers&) = delete;

 private:
  std::vector<pid_t> pids_;
};

}  // namespace tessera
