#pragma once

#include <filesystem>
#include <vector>

namespace tessera {

/// Which of the kernel's two restrictions hold.
struct Sandbox {
  bool holds_files = false;  ///< Landlock
  bool holds_calls = false;  ///< seccomp
};

/// Gives up rights of this process for good; call it while there is a single thread.
/// - Files (Landlock): only files in `readable`, which are folders or single files, can be opened,
///   for reading alone; places that are missing are ignored. Memory files stay, by their
///   `/proc/self/fd` paths too. Where the kernel knows how, no signal reaches a process outside.
/// - System calls (seccomp): new sockets, processes, programs, changes to the file system, io_uring
///   and access to other processes or a terminal's input fail with EPERM. Threads and inherited
///   sockets stay.
/// Each holds without the other where the kernel, or the container's own filter, lacks one.
Sandbox enter_sandbox(const std::vector<std::filesystem::path>& readable);

/// Where the dynamic linker finds libraries: the system's folders, their cache, and those that
/// $LD_LIBRARY_PATH names.
std::vector<std::filesystem::path> library_places();

}  // namespace tessera
