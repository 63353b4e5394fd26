#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "base/core_count.h"

namespace tessera {

struct ProcessStreams {
  int standard_input = -1;       ///< a descriptor that the process gets as its own; -1: nothing
  int standard_output = -1;      ///< likewise; -1: ours
  bool discards_output = false;  ///< standard output; errors are always shared with us
};

/// Starts `program`, found by PATH if it names no folder; `arguments` begin with its name. It has a
/// process group of its own, which a terminal's Ctrl-C does not reach, and no signal blocked or
/// ignored. Throws render_error where it cannot be started. The caller waits for its end.
pid_t start_process(const std::string& program, std::vector<std::string> arguments,
                    const ProcessStreams& streams = {});

/// Throws render_error where the stacks of so many more threads find no room (ulimit -v): told
/// before, since libraries that cannot start a thread abort.
void check_room_for_threads(int count);
/// How many of them a transport over sockets starts, at the most.
inline constexpr int kTransportThreads = 3;

/// Lowers the priority of this process by so many nice levels, more than 0; of the threads that it
/// starts from now on, and of the calling one.
void lower_priority(int nice);

/// Waits until it ends; its status as waitpid() tells it.
int wait_for_process(pid_t process);
/// "exit code 3" or "signal 11 (SEGV)".
std::string how_it_ended(int status);
/// "signal 11 (SEGV)".
std::string name_of_signal(int signal);

}  // namespace tessera
