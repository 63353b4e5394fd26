#pragma once

#include <chrono>
#include <cstdint>

namespace tessera {

/// What this process takes, as its kernel tells it; 0 where it does not.
struct ProcessUsage {
  uint64_t resident_bytes = 0;
  double cpu_seconds = 0;  ///< of all its threads
  uint64_t open_files = 0;
};
ProcessUsage process_usage();

/// Processor time of all threads of another process of this machine; 0 where there is none.
double cpu_seconds_of(int process);

/// What this machine has done since it was started, and has in memory; 0 where it does not tell.
struct MachineUsage {
  double busy_seconds = 0, all_seconds = 0;  ///< of all cores
  uint64_t used_bytes = 0, memory_bytes = 0;
};
MachineUsage machine_usage();

/// Processor time that the calling thread has had.
std::chrono::nanoseconds thread_time();

/// How many processes of our memory group (cgroup) were killed since they, together, exceeded its
/// limit; 0 where there is no limit, or none that can be read.
uint64_t memory_kills();

}  // namespace tessera
